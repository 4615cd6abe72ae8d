"""Commands that play: demo, train, evaluate."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyro.conf import FlagCreatePairsOff

from rotorpong.cli.common import (
    Common,
    Match,
    Varied,
    compile_kernels,
    knowledge_of,
    named,
    progress_bar,
    say,
    show,
    within_cores,
)


@dataclass(frozen=True, kw_only=True)
class Demo(Common):
    """Watch a drone learn: demonstrations, training, before and after, a report.html."""

    out: Path = Path("rotorpong-demo")
    """Folder for report.html, results.json and the experience."""
    ball: str = "orange"
    """orange or white."""

    def run(self) -> dict[str, Any]:
        """Play the demo."""
        from rotorpong.lab.demo import demo_table, run_demo

        compile_kernels()
        with progress_bar() as advance:
            result = run_demo(self.out, seed=self.seed, ball=self.ball, progress=advance)
        if not self.json:
            show(demo_table(result))
            say(f"report: {self.out / 'report.html'}")
        return result.as_json()


@dataclass(frozen=True, kw_only=True)
class Train(Match):
    """Train a player on its own hits, keeping every trial in a file."""

    hits: int
    """How many own hits to learn from; at most 20 balls are thrown for each. The last ball is a
    hit, so the rate of a short run flatters: measure with `evaluate`."""
    out: Path
    """The experience file."""
    resume: FlagCreatePairsOff[bool] = False
    """Go on with an existing file."""

    def run(self) -> dict[str, Any]:
        """Train."""
        from rotorpong.lab.spec import require_count
        from rotorpong.lab.train import train

        require_count("hits", self.hits)
        spec = self.spec()
        compile_kernels(self.eyes)
        with progress_bar() as advance:
            done = train(
                spec, self.hits, self.out, resume=self.resume, progress=named(advance, "hits")
            )
        result = {**done.as_json(), "experience": str(self.out)}
        if not self.json:
            say(f"{done.hits} hits of {done.balls} balls, kept in {self.out}")
        return result


@dataclass(frozen=True, kw_only=True)
class Evaluate(Varied):
    """Measure a player on a fixed number of serves; it never learns here."""

    balls: int = 100
    """How many serves."""
    experience: Path | None = None
    """What a player that learns has learnt: a file of `train`; others do not use it. Default: ten
    scripted demonstrations."""
    against: tuple[Path, ...] = ()
    """What `evaluate --json` printed for others on the same balls: tells which of the balls only
    one of the two hit, and how likely that is by chance; of hover and oracle also the skill."""
    racket: str = "cardboard"
    """cardboard or rubber."""
    blackout: FlagCreatePairsOff[bool] = False
    """Make every frame black."""
    workers: int = 1
    """Processes, at most one for each core; the results do not depend on it."""

    def run(self) -> dict[str, Any]:
        """Evaluate."""
        from rotorpong.lab.comparison import compared, read_evaluation, require_same_balls
        from rotorpong.lab.evaluate import evaluate, header, summary
        from rotorpong.lab.spec import require_count
        from rotorpong.lab.tables import summary_table

        require_count("balls", self.balls)
        require_count("workers", self.workers)
        spec = self.spec(racket=self.racket, blackout=self.blackout, randomize=self.randomize)
        head = header(spec, self.balls, self.experience)
        others = [read_evaluation(path) for path in self.against]
        for other in others:
            require_same_balls(head, other)
        known = knowledge_of(spec, self.experience)
        compile_kernels(self.eyes)
        with progress_bar() as advance:
            results = evaluate(
                spec,
                self.balls,
                knowledge=known,
                workers=within_cores(self.workers),
                progress=named(advance, "balls"),
            )
        result = summary(spec, results, head)
        result |= compared(result, others)
        if not self.json:
            show(summary_table(result))
        return result

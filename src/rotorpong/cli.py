"""The command line: arguments -> calls.

Every command takes `--json` (stdout then carries one JSON object on one line and nothing else) and
`--seed`. Exit status: 0 success, 2 bad input with one line on stderr, 130 Ctrl-C, 1
a doctor that found a problem. Progress goes to
stderr. What is heavy is imported by the command that needs it, so that `--help` is quick.
"""

import contextlib
import io
import json
import logging
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NoReturn

import tyro
from tyro.conf import FlagCreatePairsOff, Positional, subcommand

BAD_INPUT = 2
INTERRUPTED = 130
UNFIT = 1  # doctor found a problem


@dataclass(frozen=True, kw_only=True)
class Common:
    """What every command takes."""

    seed: int = 0
    """Same seed, same serves."""
    json: FlagCreatePairsOff[bool] = False
    """Print one JSON object on stdout and nothing else."""


@dataclass(frozen=True, kw_only=True)
class Demo(Common):
    """Watch a drone learn: demonstrations, training, before and after, a report.html."""

    out: Path = Path("rotorpong-demo")
    """Folder for report.html, results.json and the experience."""

    def run(self) -> dict[str, Any]:
        """Play the demo."""
        from rotorpong.lab.demo import demo_table, run_demo

        _compile_kernels()
        with _progress() as advance:
            result = run_demo(self.out, seed=self.seed, progress=advance)
        if not self.json:
            _show(demo_table(result))
            _say(f"report: {self.out / 'report.html'}")
        return result.as_json()


@dataclass(frozen=True, kw_only=True)
class Match(Common):
    """Who plays against what."""

    player: str = "paper"
    """hover, paper, or your own as FILE.py:CLASS."""
    eyes: str = "paper"
    """truth or paper."""
    vehicle: str = "tum_gazebo"
    """tum_gazebo."""
    camera: str = "gazebo"
    """gazebo, ardrone2_720p, or your calibration as FILE."""
    serves: str = "human"
    """human, constant, or FILE.csv of serves or of a measured flight."""


@dataclass(frozen=True, kw_only=True)
class Train(Match):
    """Train a player on its own hits, keeping every trial in a file."""

    hits: int
    """How many own hits to learn from; at most 20 balls are thrown for each."""
    out: Path
    """The experience file."""
    resume: FlagCreatePairsOff[bool] = False
    """Go on with an existing file."""

    def run(self) -> dict[str, Any]:
        """Train."""
        from rotorpong.lab.spec import Spec, require_count
        from rotorpong.lab.train import train

        require_count("hits", self.hits)
        spec = Spec(self.player, self.eyes, self.vehicle, self.camera, self.serves, self.seed)
        spec.check()
        _compile_kernels()
        with _progress() as advance:
            done = train(
                spec, self.hits, self.out, resume=self.resume, progress=_named(advance, "hits")
            )
        result = {**done.as_json(), "experience": str(self.out)}
        if not self.json:
            _say(f"{done.hits} hits of {done.balls} balls, kept in {self.out}")
        return result


@dataclass(frozen=True, kw_only=True)
class Evaluate(Match):
    """Measure a player on a fixed number of serves; it never learns here."""

    balls: int = 100
    """How many serves."""
    experience: Path | None = None
    """What the player learnt: a file of `train`. Default: ten scripted demonstrations."""
    racket: str = "cardboard"
    """cardboard or rubber."""
    blackout: FlagCreatePairsOff[bool] = False
    """Make every frame black."""
    workers: int = 1
    """Processes; the results do not depend on it."""

    def run(self) -> dict[str, Any]:
        """Evaluate."""
        from rotorpong.lab.evaluate import evaluate, summary
        from rotorpong.lab.spec import Spec, require_count
        from rotorpong.lab.tables import summary_table

        require_count("balls", self.balls)
        require_count("workers", self.workers)
        spec = Spec(
            self.player,
            self.eyes,
            self.vehicle,
            self.camera,
            self.serves,
            self.seed,
            self.racket,
            self.blackout,
        ).check()
        known = self._knowledge()
        _compile_kernels()
        with _progress() as advance:
            results = evaluate(
                spec,
                self.balls,
                knowledge=known,
                workers=self.workers,
                progress=_named(advance, "balls"),
            )
        result = summary(spec, results)
        if not self.json:
            _show(summary_table(result))
        return result

    def _knowledge(self) -> Any:
        if self.experience is None:
            return None
        from rotorpong.lab.train import knowledge_of

        run, knowledge = knowledge_of(self.experience)
        for what in ("eyes", "camera", "vehicle", "serves"):
            then, now = getattr(run, what), getattr(self, what)
            if then != now:
                _say(f"{self.experience} was recorded with {what} {then}, not {now}")
        return knowledge


@dataclass(frozen=True, kw_only=True)
class Detect(Common):
    """Find balls in pictures, folders of pictures, and videos."""

    path: Positional[tuple[Path, ...]]
    """Pictures, folders, videos."""
    camera: str | None = None
    """gazebo, ardrone2_720p or a calibration FILE: adds positions in metres."""
    eyes: str = "paper"
    """paper."""
    colour: str = "orange"
    """orange, white, or both as orange,white."""
    ball_diameter_mm: float = 40.0
    """Of the real ball."""
    min_score: float = 0.0
    """Leave out what looks less like a ball than this, 0 to 1."""
    out: Path | None = None
    """Folder for annotated pictures."""

    def run(self) -> dict[str, Any]:
        """Detect."""
        from rotorpong.lab.detect import Search, detect_all
        from rotorpong.lab.tables import detection_table

        search = Search(
            self.camera,
            self.eyes,
            tuple(self.colour.split(",")),
            self.ball_diameter_mm / 1000.0,
            self.min_score,
        )
        with _progress() as advance:
            result = detect_all(self.path, search, self.out, _named(advance, "pictures"))
        if not self.json:
            _show(detection_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class FromFlight(Common):
    """Turn a measured flight, or a folder of them, into serves."""

    flight: Positional[Path]
    """CSV of time and position, or a folder."""
    out: Path
    """The CSV of serves that `evaluate --serves` throws."""

    def run(self) -> dict[str, Any]:
        """Convert."""
        from rotorpong.lab.from_flight import convert
        from rotorpong.lab.serve_files import write_serves
        from rotorpong.lab.tables import conversion_table

        conversion = convert(self.flight)
        write_serves(self.out, tuple(made.serve for made in conversion.serves))
        result = {**conversion.as_json(), "out": str(self.out)}
        if not self.json:
            _show(conversion_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class Stats(Common):
    """Describe a kind of serves as a camera sees them."""

    serves: str = "human"
    """human, constant, or FILE.csv."""
    camera: str = "gazebo"
    """gazebo, ardrone2_720p, or your calibration as FILE."""
    balls: int = 200
    """How many serves."""

    def run(self) -> dict[str, Any]:
        """Throw them at a hovering drone."""
        from rotorpong.lab.serve_stats import serve_stats
        from rotorpong.lab.spec import Spec, require_count
        from rotorpong.lab.tables import stats_table

        require_count("balls", self.balls)
        spec = Spec("hover", camera=self.camera, serves=self.serves, seed=self.seed).check()
        _compile_kernels()
        with _progress() as advance:
            result = serve_stats(spec, self.balls, progress=_named(advance, "balls"))
        if not self.json:
            _show(stats_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class Serves:
    """Serves: where they come from and what they are like."""

    command: Annotated[
        Annotated[FromFlight, subcommand("from-flight")] | Annotated[Stats, subcommand("stats")],
        tyro.conf.arg(name=""),
    ]

    @property
    def json(self) -> bool:
        """Whether JSON is asked for."""
        return self.command.json

    @property
    def seed(self) -> int:
        """The seed of what was chosen."""
        return self.command.seed

    def run(self) -> dict[str, Any]:
        """Run what was chosen."""
        return self.command.run()


@dataclass(frozen=True, kw_only=True)
class Doctor(Common):
    """Say what this machine has, and whether rotorpong works on it."""

    clear_cache: FlagCreatePairsOff[bool] = False
    """Delete the compiled kernels first."""

    def run(self) -> dict[str, Any]:
        """Examine."""
        from rotorpong.lab.doctor import examine
        from rotorpong.lab.tables import findings_table

        with _progress() as advance:
            result = examine(clear_cache=self.clear_cache, progress=_named(advance, "checks"))
        if not self.json:
            _show(findings_table(result))
        return result


Command = (
    Annotated[Demo, subcommand("demo")]
    | Annotated[Train, subcommand("train")]
    | Annotated[Evaluate, subcommand("evaluate")]
    | Annotated[Detect, subcommand("detect")]
    | Annotated[Serves, subcommand("serves")]
    | Annotated[Doctor, subcommand("doctor")]
)


def main() -> NoReturn:
    """Run one command and exit."""
    logging.basicConfig(format="rotorpong: %(message)s")
    try:
        status = _run(sys.argv[1:])
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is left is only tidying up
        _say("interrupted")
        status = INTERRUPTED
    sys.exit(status)


def _run(arguments: list[str]) -> int:
    from rotorpong.conventions import RotorpongError, require_seed

    command = _parsed(arguments)
    try:
        require_seed(command.seed)
        with contextlib.redirect_stdout(sys.stderr) if command.json else contextlib.nullcontext():
            result = command.run()
        if command.json:
            print(json.dumps(result, allow_nan=False), flush=True)  # noqa: T201
        return 0 if result.get("ok", True) else UNFIT
    except BrokenPipeError:  # whoever read stdout had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (RotorpongError, OSError) as error:
        _say(" ".join(str(error).split()))
        return BAD_INPUT
    return 0


def _parsed(arguments: list[str]) -> Any:
    """Parse; where tyro would print a box, print one line."""
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box):
            return tyro.cli(
                Command,  # pyright: ignore[reportArgumentType]
                prog="rotorpong",
                args=arguments or ["--help"],
                description="A quadrotor that learns to play table tennis with one onboard camera.",
            )
    except SystemExit as exit_:
        if exit_.code not in (0, None):
            _say(_one_line(box.getvalue()))
            sys.exit(BAD_INPUT)
        raise


def _one_line(box: str) -> str:
    """Return the words of a box of text, its parts divided by semicolons."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", box)
    parts = re.split(r"[─-]{3,}", re.sub(r"[│╭╮╰╯┌┐└┘├┤]", " ", plain))
    title, *said = [" ".join(part.split()) for part in parts if part.strip("─ \n")]
    return "; ".join(said or [title])


def _compile_kernels() -> None:
    """Compile what is not compiled yet, saying so once."""
    from rotorpong.kernels import CACHE_FOLDER
    from rotorpong.lab.warmup import warm_up

    if CACHE_FOLDER is None or not any(CACHE_FOLDER.rglob("*.nbi")):
        _say("compiling kernels (once, about a minute) ...")
    warm_up()


Advance = Callable[[str, int, int], None]


@contextlib.contextmanager
def _progress() -> Iterator[Advance]:
    """Give a bar on stderr if that is a terminal; call it with (what, done, of how many)."""
    if not sys.stderr.isatty():
        yield lambda what, done, total: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        tasks: dict[str, Any] = {}

        def advance(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total)
            bar.update(tasks[what], completed=done)

        yield advance


def _named(advance: Advance, what: str) -> Callable[[int, int], None]:
    return lambda done, total: advance(what, done, total)


def _show(table: Any) -> None:
    from rich.console import Console

    Console().print(table)


def _say(line: str) -> None:
    print(f"rotorpong: {line}", file=sys.stderr)  # noqa: T201

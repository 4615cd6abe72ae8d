"""What commands share: options, progress on stderr, tables on stdout."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyro.conf import FlagCreatePairsOff


@dataclass(frozen=True, kw_only=True)
class Common:
    """What every command takes."""

    seed: int = 0
    """Same seed, same serves and same noise."""
    json: FlagCreatePairsOff[bool] = False
    """Print one JSON object on stdout and nothing else."""


@dataclass(frozen=True, kw_only=True)
class Match(Common):
    """Who plays against what."""

    player: str = "paper"
    """hover, nearest, single, paper, bandit, oracle, or your own as FILE.py:CLASS."""
    eyes: str = "paper"
    """truth, paper or tracker."""
    vehicle: str = "tum_gazebo"
    """tum_gazebo, ardrone2, or ardrone2_raw."""
    camera: str = "gazebo"
    """gazebo, ardrone2_360p, ardrone2_720p, or your calibration as FILE."""
    serves: str = "human"
    """human, constant, hard, lob, or FILE.csv of serves or of a measured flight."""
    ball: str = "orange"
    """orange or white."""
    colour: str | None = None
    """What eyes look for: orange, white, or a FILE.json of `calibrate colour`. Default: the
    ball's."""
    circle_fit: str | None = None
    """Of eyes paper: kasa (regularised least squares, the default), pratt, taubin or geometric."""
    diameter: str | None = None
    """Of eyes paper: whole pixels as in the paper (the default), or float."""

    labels: str | None = None
    """Of player paper or single, what hitting points are learnt from: commanded (where it meant to
    be, the default) or achieved (where it was, as in the paper)."""
    length_scale: float | None = None
    """Of players paper, single and bandit: of CrKR's kernel, in standard deviations of the
    demonstrations; 3 by default."""
    regularization: float | None = None
    """Of the same players: lambda of CrKR, the variance of a label in m^2; 0.1 by default."""
    tune: FlagCreatePairsOff[bool] = False
    """Of the same players: CrKR finds length scales and lambda itself, by marginal likelihood."""
    trigger: str | None = None
    """Of players nearest, single, paper and bandit, what sets them going: the ball behind a plane
    before the camera (plane, the default), or within a distance of it (distance)."""
    plane_distance_m: float | None = None
    """Of the same players: how far that is, 0.8 to 4; 2.5 by default."""
    exploration_sd_m: float | None = None
    """Of players paper and single while they train: how widely hitting points are varied, each
    axis, 0 to 1; 0.1 by default."""
    selection: str | None = None
    """Of players paper and bandit, how primitives are weighed by the reward V that each promises:
    paper (exp(V), the default), temperature (exp(V / temperature)), or one alone: greedy (largest
    V), thompson (largest V drawn), ucb (largest V + deviations sd(V))."""
    temperature: float | None = None
    """Of selection temperature, in units of the reward; 1 by default."""
    deviations: float | None = None
    """Of selection ucb; 1 by default."""
    learn_from_misses: FlagCreatePairsOff[bool] = False
    """Of players paper and bandit: a miss teaches what primitives are worth, with reward 0."""
    primitive: int | None = None
    """Of player single: the number of the demonstration whose motion it flies, from 0; by default
    that which was rewarded best."""
    control: str | None = None
    """How motions are flown, players nearest, single, paper and bandit: open as in the paper (the
    default), feed-forward, or closed-loop."""

    def spec(self, **more: Any) -> Any:
        """Return the checked spec of this match; `more` are fields that not every match has."""
        from rotorpong.lab.eye_settings import EyeSettings
        from rotorpong.lab.player_settings import PlayerSettings
        from rotorpong.lab.spec import Spec

        match = (self.player, self.eyes, self.vehicle, self.camera, self.serves, self.seed)
        chosen = {
            "ball": self.ball,
            "eye_settings": EyeSettings(self.circle_fit, self.diameter, self.colour),
            "player_settings": PlayerSettings(
                labels=self.labels,
                length_scale=self.length_scale,
                regularization=self.regularization,
                tune=self.tune or None,
                trigger=self.trigger,
                plane_distance=self.plane_distance_m,
                exploration_sd=self.exploration_sd_m,
                selection=self.selection,
                temperature=self.temperature,
                deviations=self.deviations,
                learn_from_misses=self.learn_from_misses or None,
                primitive=self.primitive,
            ),
            "control": self.control,
        }
        return Spec(*match, **chosen, **more).check()


@dataclass(frozen=True, kw_only=True)
class Varied(Match):
    """Who plays against what, and whether that is another thing every ball."""

    randomize: FlagCreatePairsOff[bool] = False
    """Draw drone, sensors, ball, camera and looks anew for every ball, within what is known. Serves
    of a FILE keep the ball, drag, restitution and friction that were measured with them."""


SAID = {
    "spec.ball": "ball",
    "spec.eye_settings": "setting of the eyes",
    "colour": "colour",
}
SAID_OF_LEARNERS = {"spec.player_settings": "setting of the player", "spec.control": "control"}


def knowledge_of(spec: Any, experience: Path | None) -> Any:
    """Return what an experience file taught, saying where it is of another spec; None without."""
    if experience is None:
        return None
    from rotorpong.lab import train
    from rotorpong.lab.spec import LEARNERS

    run, knowledge = train.knowledge_of(experience)
    ours = train.run_of(spec)
    whose, said = (), SAID
    if spec.player in LEARNERS:
        whose, said = ("player",), SAID | SAID_OF_LEARNERS
    for what in (*whose, "eyes", "camera", "vehicle", "serves"):
        then, now = getattr(run, what), getattr(ours, what)
        if run.identity()[what] != ours.identity()[what]:
            contents = f"{what} {then}, not {now}" if then != now else f"another {what} {now}"
            say(f"{experience} was recorded with {contents}")
    for what, words in said.items():
        if run.identity().get(what) != ours.identity().get(what):
            say(f"{experience} was recorded with another {words}")
    return knowledge


def within_cores(workers: int) -> int:
    """Return how many workers the cores can feed, saying so where that is fewer than asked for."""
    from rotorpong.lab.workers import cores

    if workers > cores():
        say(f"{workers} workers asked for, {cores()} cores available: {cores()} play")
    return min(workers, cores())


def compile_kernels(eyes: str = "paper") -> None:
    """Compile what is not compiled yet, saying so once; what only the tracker needs, for it."""
    from rotorpong.kernels import CACHE_FOLDER
    from rotorpong.lab.warmup import warm_up

    if CACHE_FOLDER is None or not any(CACHE_FOLDER.rglob("*.nbi")):
        say("compiling kernels (once, about a minute) ...")
    warm_up(eyes=eyes)


Advance = Callable[[str, int, int], None]


@contextlib.contextmanager
def progress_bar() -> Iterator[Advance]:
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


def named(advance: Advance, what: str) -> Callable[[int, int], None]:
    """Return what advances one bar of `progress_bar`, called with (done, of how many)."""
    return lambda done, total: advance(what, done, total)


def show(table: Any) -> None:
    """Print a table on stdout."""
    from rich.console import Console

    Console().print(table)


def say(line: str) -> None:
    """Print a line on stderr."""
    print(f"rotorpong: {line}", file=sys.stderr)  # noqa: T201

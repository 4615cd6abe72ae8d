"""Paper against ours: every number of the paper's text and tables beside ours, and why they differ.

Ours are taken from the results of the other items; what an item did not tell, or an item that is
not there, is None. Numbers that are settings on both sides come from the code's own constants.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rotorpong.conventions import BALL_DIAMETER
from rotorpong.experience import shipped_demonstrations
from rotorpong.paper import fig7b, ladder, real, table1, table2
from rotorpong.paper.discussion import discussion
from rotorpong.paper.findings import Findings, Line
from rotorpong.paper.readings import (
    DEPTH_SHARE,
    HIT_PERCENT,
    PORTED,
    ROBOT,
    TABLE1,
    TABLE2,
    At,
    Told,
    first,
    last,
    near_of_misses,
    plateau,
    worst_axis,
)
from rotorpong.paper.trajectory import HEADS, KEYS
from rotorpong.physics.camera import CAMERAS
from rotorpong.play.paper import PaperSettings
from rotorpong.world.racket import Racket

TITLE = "Paper against ours"
CODE = "the code's constants"


@dataclass(frozen=True, slots=True)
class Claim:
    """A number or statement of the paper and what it is here."""

    where: str  # in the paper
    what: str  # with the unit
    paper: float | None  # None: told in words
    ours: float | None
    source: str  # item and line that ours is of
    digits: int = 1
    interval: Sequence[float] | None = None  # 95 %, of ours

    @property
    def label(self) -> str:
        """How the claim is called in results.json."""
        return f"{self.where}: {self.what}"


def findings(results: Mapping[str, Any]) -> Findings:
    """Set the paper's numbers beside those of all items.

    Args:
        results: by item, as `reproduce` returns them; any may be missing.
    """
    told = Told(results)
    rows = claims(told)
    return Findings(
        columns=(),
        paper=[Line(row.label, {"value": row.paper}) for row in rows],
        ours=[
            Line(row.label, {"value": row.ours, "interval": row.interval, "source": row.source})
            for row in rows
        ],
        setting={},
        remarks="\n\n".join(["\n".join(_table(rows)), *discussion(told)]),
    )


def claims(told: Told) -> tuple[Claim, ...]:
    """Return every number of the paper, in its order."""
    return (
        *_equipment(),
        *_eyes(told),
        *_execution(told),
        *_library(told),
        *_learning(told),
        *_robot(told),
    )


def _equipment() -> Iterator[Claim]:
    camera, racket = CAMERAS["ardrone2_720p"], Racket()
    yield Claim("II-A", "camera, lines", 720.0, float(camera.height_px), CODE, 0)
    yield Claim("II-A", "camera, frames/s", 30.0, camera.frames_per_second, CODE, 0)
    size = "racket of official size (an ITTF blade)"
    yield Claim("II-A", f"{size}, width, cm", 15.0, 200.0 * racket.half_width, CODE)
    yield Claim("II-A", f"{size}, height, cm", 15.7, 200.0 * racket.half_height, CODE)
    yield Claim("II-B", "balls that the robot arm of Muelling et al. returns, %", 94.0, None,
                "context: ours intercepts and does not return", 0)  # fmt: skip
    yield Claim("III", "ball's diameter, cm", 4.0, 100.0 * BALL_DIAMETER, CODE)


def _eyes(told: Told) -> Iterator[Claim]:
    line = TABLE1["centred"]
    for key, head in zip(KEYS, HEADS, strict=True):
        yield _claim(
            told, ("Table I", f"error of {head}"), table1.PAPER[key], ("table1", line, key)
        )
    share = ("table1", line, "x_over_z")
    yield _claim(told, ("Table I", "error of X over that of Z"), DEPTH_SHARE, share, 3)
    count = told.setting("table1", "trajectories")
    yield Claim("Table I", "trajectories", 20.0, count, "table1", 0)


def _execution(told: Told) -> Iterator[Claim]:
    for key, head, paper in zip(table2.KEYS, HEADS, table2.PAPER, strict=True):
        what = ("Table II", f"execution error of {head}")
        yield _claim(told, what, paper, ("table2", TABLE2, key))
    around = '"error generally remains around 5cm"; the axis with most, cm'
    yield Claim("IV-D", around, 5.0, worst_axis(told), f"table2: {TABLE2}", 2)
    yield Claim("Table II", "runs", 10.0, told.setting("table2", "runs"), "table2", 0)


def _library(told: Told) -> Iterator[Claim]:
    distance = PaperSettings().plane_distance
    yield Claim("IV-B", "plane where a motion begins, m", 2.5, distance, CODE)
    seen = ("fig6", "plane, paper's eyes", "depth_m")
    yield _claim(told, ("IV-B", "the same, true depth when vision has it there, m"), 2.5, seen)
    shown = float(len(shipped_demonstrations()))
    yield Claim("V", "demonstrations, one DMP each", 10.0, shown, "the shipped ones", 0)


def _learning(told: Told) -> Iterator[Claim]:
    before, after = ("fig7b", first("vision", told)), ("fig7b", last("vision", told))
    learnt = ("V", "successful hits learnt from")
    yield _claim(told, learnt, 170.0, (*after, "own_hits"), 0)
    fired = told.setting("fig7b", "balls_per_seed")
    yield Claim("V", "balls fired at the robot (ours: with each seed)", 100.0, fired, "fig7b", 0)
    untrained = ("V", "hits before learning, simulated (told of the robot), %")
    yield _claim(told, untrained, fig7b.ROBOT_PERCENT, (*before, HIT_PERCENT), 1)
    trained = ("VI", "hits after learning, simulated, %")
    yield _claim(told, trained, fig7b.PAPER_PERCENT, (*after, HIT_PERCENT), 1)
    best = ("VI", "the same with tracker eyes and closed loop, %")
    yield _claim(told, best, fig7b.PAPER_PERCENT, ("ladder", ladder.CLOSED, HIT_PERCENT), 1)
    for label in fig7b.EYES:
        what = f'plateau, "sooner when using the vision system": begins after own hits, {label}'
        yield Claim("V", what, None, plateau(label, told), f"fig7b: {label}", 0)
    almost = '"several missed balls were almost-hits": share of misses, %'
    yield Claim("V", almost, None, near_of_misses(told), ": ".join(after))


def _robot(told: Told) -> Iterator[Claim]:
    for test, stages in ROBOT.items():
        for stage, what, paper in zip(real.STAGES[1:], stages, real.PAPER[test], strict=True):
            at = ("real", f"{PORTED}, {test}, {stage}", HIT_PERCENT)
            yield _claim(told, ("V, robot", f"hits, {what}, %"), paper, at, 1)


def _claim(told: Told, what: tuple[str, str], paper: float, at: At, digits: int = 2) -> Claim:
    item, line, _ = at
    return Claim(*what, paper, told.value(at), f"{item}: {line}", digits, told.interval(at))


def _table(rows: Sequence[Claim]) -> Iterator[str]:
    yield "| in the paper | what | paper | ours | ours is of |"
    yield "|---|---|---:|---:|---|"
    for row in rows:
        paper = "in words" if row.paper is None else _shown(row.paper, row.digits)
        ours = _shown(row.ours, row.digits)
        if row.interval is not None:
            ours += " ({} to {})".format(*(_shown(end, row.digits) for end in row.interval))
        yield f"| {row.where} | {row.what} | {paper} | {ours} | {row.source} |"


def _shown(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"

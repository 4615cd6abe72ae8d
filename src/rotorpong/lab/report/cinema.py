"""One serve as pictures for people: onboard view and onlooker's view side by side, with a title.

A shot shows the world at one time: on the left the newest frame of the onboard camera, with what
the eyes made of it, on the right what somebody beside the table sees. Below runs the time.
"""

import functools
from dataclasses import dataclass
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
from jaxtyping import Float
from numpy import ndarray
from PIL import Image, ImageDraw, ImageFont

from rotorpong.conventions import Picture
from rotorpong.lab.footage import Sight, Take
from rotorpong.lab.player_settings import DECIDING_ONCE
from rotorpong.lab.report.film import circle_in_picture
from rotorpong.lab.report.onlooker import HEIGHT, WIDTH, Instant, picture_of, seen_at
from rotorpong.lab.trial import Stage
from rotorpong.world.contact import TICK

HEAD, FOOT, GAP = 52, 44, 4  # px
FRAME_SIZE = (2 * WIDTH + GAP, HEAD + HEIGHT + FOOT)
TRAIL_S = 0.30
DARK, PALE, QUIET = (24, 22, 20), (240, 238, 236), (150, 146, 142)  # blue, green, red
MARK, CLOCK = (255, 0, 255), (60, 170, 255)
MARKS = (MARK, CLOCK)
VERDICTS = {"hit": (96, 190, 60), "near_hit": (40, 170, 240)}
LOST = (80, 80, 225)
WORDS = {"near_hit": "NEAR HIT", "hull": "ON THE HULL"}


@dataclass(frozen=True, slots=True)
class Scenery:
    """What all shots of a serve share."""

    stage: Stage
    take: Take

    @property
    def duration(self) -> float:
        """From release to the end of the serve, s."""
        return (len(self.take.played.truth.ball_path) - 1) * TICK


def shot(scenery: Scenery, time: float, *, ended: bool = False) -> Picture:
    """Return the picture of the serve at `time`.

    Args:
        scenery: the serve.
        time: s since release, up to its duration.
        ended: show how it ended.
    """
    picture = np.full((*FRAME_SIZE[::-1], 3), DARK, np.uint8)
    left, right = onboard(scenery, time), beside(scenery, time, ended=ended)
    picture[HEAD : HEAD + HEIGHT, :WIDTH] = left
    picture[HEAD : HEAD + HEIGHT, WIDTH + GAP :] = right
    _draw_clock(picture, scenery, time)
    return _written(picture, _words(scenery, time, ended=ended))


def onboard(scenery: Scenery, time: float) -> Picture:
    """Return the newest frame at `time` with what the eyes made of it, as large as a panel."""
    sight = _newest(scenery.take.sights, time)
    if sight is None:
        return np.full((HEIGHT, WIDTH, 3), DARK, np.uint8)
    picture = sight.observation.frame.picture.copy()
    if sight.estimate is not None and scenery.stage.spec.eyes != "truth":
        camera = scenery.stage.setting.camera  # what the eyes take theirs for
        center, radius = circle_in_picture(camera, sight.estimate.position)
        _circle(picture, center, max(1.25 * radius, radius + 4.0), MARK)
    return _fitted(picture)


def beside(scenery: Scenery, time: float, *, ended: bool = False) -> Picture:
    """Return the onlooker's picture at `time`, at the end with a ring about the ball."""
    truth, setting = scenery.take.played.truth, scenery.take.setting
    tick = min(round(time / TICK), len(truth.ball_path) - 1)
    first = max(0, tick - round(TRAIL_S / TICK))
    instant = Instant(
        truth.ball_path[tick],
        truth.body_path[tick],
        truth.attitude_path[tick],
        truth.ball_path[np.unique([*range(first, tick, 10), tick])],
    )
    picture = picture_of(instant, setting.racket, setting.scene)
    if ended:
        colour = VERDICTS.get(scenery.take.played.outcome, LOST)
        _circle(picture, seen_at(instant.ball), 22.0, colour)
    return picture


def contact_sheet(scenery: Scenery, moments: Float[ndarray, "n"], columns: int) -> Picture:
    """Return moments of a serve on one sheet: onboard above, beside the table below.

    Args:
        scenery: the serve.
        moments: s, in order.
        columns: how many stand side by side.
    """
    cells = [
        _cell(scenery, float(moment), ended=k == len(moments) - 1)
        for k, moment in enumerate(moments)
    ]
    blank = np.full_like(cells[0], DARK)
    cells += [blank] * (-len(cells) % columns)
    rows = [np.hstack(cells[k : k + columns]) for k in range(0, len(cells), columns)]
    sheet = np.vstack([np.full((HEAD + 6, rows[0].shape[1], 3), DARK, np.uint8), *rows])
    head = _words(scenery, scenery.duration, ended=True, width=sheet.shape[1])
    return _written(sheet, [word for word in head if word.y < HEAD])


def _cell(scenery: Scenery, time: float, *, ended: bool) -> Picture:
    size = (WIDTH * 3 // 4, HEIGHT * 3 // 4)
    views = [onboard(scenery, time), beside(scenery, time, ended=ended)]
    small = [cv2.resize(view, size, interpolation=cv2.INTER_AREA) for view in views]
    cell = np.full((2 * size[1] + 26 + 2 * GAP, size[0] + GAP, 3), DARK, np.uint8)
    cell[22 : 22 + size[1], : size[0]] = small[0]
    cell[22 + size[1] + GAP : 22 + 2 * size[1] + GAP, : size[0]] = small[1]
    ball = scenery.take.played.truth.ball_path
    text = f"{time:.2f} s, ball {_speed(ball, time):.1f} m/s"
    return _written(cell, [_Word(text, 4, 3, 14, QUIET)])


@dataclass(frozen=True, slots=True)
class _Word:
    """A piece of text: its place is its upper left corner, or upper right where it ends there."""

    text: str
    x: int
    y: int
    size: int
    colour: tuple[int, int, int]
    bold: bool = False
    ends: bool = False


def _words(
    scenery: Scenery, time: float, *, ended: bool, width: int = FRAME_SIZE[0]
) -> list[_Word]:
    spec, played = scenery.stage.spec, scenery.take.played
    ball, body = played.truth.ball_path, played.truth.body_path
    who = f"{_short(spec.player)} player, {spec.eyes} eyes"
    serves = _short(spec.serves_name)
    what = f"{spec.vehicle_name}  ·  serve {serves} {played.index}, seed {spec.seed}"
    what += "  ·  randomised" if spec.randomize else ""
    now = f"ball {_speed(ball, time):4.1f} m/s    drone {_speed(body, time):3.1f} m/s"
    sight = _newest(scenery.take.sights, time)
    seen = "" if sight is None else f", frame of {sight.observation.frame_time:.2f} s"
    right, low = width - 14, HEAD + HEIGHT + 20
    words = [
        _Word(who, 14, 7, 18, PALE, bold=True),
        _Word(what, 14, 31, 13, QUIET),
        _Word(f"onboard camera {_short(spec.camera_name)}{seen}", 14, low, 13, QUIET),
        _Word("beside the table", WIDTH + GAP + 14, low, 13, QUIET),
        _Word(now, right, low, 13, PALE, ends=True),
    ]
    if ended:
        outcome, colour = played.outcome, VERDICTS.get(played.outcome, LOST)
        badge = WORDS.get(outcome, outcome.upper())
        words.append(_Word(badge, right, 5, 22, colour, bold=True, ends=True))
        words.append(_Word(_result(scenery), right, 33, 13, QUIET, ends=True))
    else:
        words.append(_Word(f"{time:.2f} s", right, 10, 22, PALE, bold=True, ends=True))
    return words


def _result(scenery: Scenery) -> str:
    played = scenery.take.played
    truth, miss = played.truth, played.miss_distance
    after = f"after {scenery.duration:.2f} s"
    if miss is None:
        return "the player broke off"
    if truth.verdict.contact_offset is not None:
        share = 100 * truth.verdict.contact_offset
        return f"{share:.0f} % of the way from the blade's middle to its edge, {after}"
    return f"missed by {100 * miss:.1f} cm, {after}"


def _speed(path: Float[ndarray, "n 3"], time: float) -> float:
    """Return how fast the end of a path moves at `time`, m/s."""
    tick = min(max(round(time / TICK), 5), len(path) - 1)
    back = min(5, tick)
    return float(np.linalg.norm(path[tick] - path[tick - back])) / (max(back, 1) * TICK)


def _short(name: str) -> str:
    """Return the last part of a path, or the name as it is."""
    return Path(name).name


def _newest(sights: tuple[Sight, ...], time: float) -> Sight | None:
    """Return the last sight exposed by `time`, before that the first."""
    before = [sight for sight in sights if sight.observation.frame_time <= time + TICK / 2]
    return before[-1] if before else next(iter(sights), None)


def _draw_clock(picture: Picture, scenery: Scenery, time: float) -> None:
    """Draw the time line below the panels, and when a player that does so once decides."""
    y, x0, x1 = HEAD + HEIGHT + 9, 14, FRAME_SIZE[0] - 14
    here = x0 + round((x1 - x0) * min(time / scenery.duration, 1.0))
    cv2.line(picture, (x0, y), (x1, y), (70, 66, 62), 3, cv2.LINE_AA)
    cv2.line(picture, (x0, y), (here, y), CLOCK, 3, cv2.LINE_AA)
    cv2.circle(picture, (here, y), 5, PALE, -1, cv2.LINE_AA)
    trigger = scenery.take.trigger
    if trigger is not None and scenery.stage.spec.player in DECIDING_ONCE:
        there = x0 + round((x1 - x0) * trigger.time / scenery.duration)
        cv2.line(picture, (there, y - 6), (there, y + 6), MARK, 2, cv2.LINE_AA)


def _circle(picture: Picture, center: ndarray, radius: float, colour: tuple[int, int, int]) -> None:
    if np.isfinite(center).all() and np.abs(center).max() < 1e4:
        x, y = (round(16 * float(value)) for value in center)
        thickness = max(2, round(picture.shape[1] / 400))
        cv2.circle(picture, (x, y), round(16 * radius), colour, thickness, cv2.LINE_AA, 4)


def _fitted(picture: Picture) -> Picture:
    """Return a picture scaled to fit a panel, with bars where its shape is another."""
    height, width = picture.shape[:2]
    scale = min(WIDTH / width, HEIGHT / height)
    size = (max(1, round(scale * width)), max(1, round(scale * height)))
    if size != (width, height):
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    panel = np.full((HEIGHT, WIDTH, 3), DARK, np.uint8)
    x, y = (WIDTH - size[0]) // 2, (HEIGHT - size[1]) // 2
    panel[y : y + size[1], x : x + size[0]] = picture
    return panel


def _written(picture: Picture, words: list[_Word]) -> Picture:
    image = Image.fromarray(np.ascontiguousarray(picture[..., ::-1]))
    draw = ImageDraw.Draw(image)
    for word in words:
        font, anchor = _font(word.size, bold=word.bold), "ra" if word.ends else "la"
        draw.text((word.x, word.y), word.text, word.colour[::-1], font, anchor)
    return np.ascontiguousarray(np.asarray(image)[..., ::-1])


@functools.lru_cache(maxsize=16)
def _font(size: int, *, bold: bool) -> ImageFont.FreeTypeFont:
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(mpl.get_data_path()) / "fonts" / "ttf" / name), size)

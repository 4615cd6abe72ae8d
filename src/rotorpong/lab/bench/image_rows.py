"""Rows of `rotorpong bench eyes --images`: what `detect` finds in labelled pictures.

A detection is right if the square around its circle and a labelled box that no better detection has
taken overlap by half (intersection over union); best score first. With all detections of a set at
or above a threshold on the score,

    recall = right / labelled,   precision = right / detected

and the first is given for the lowest threshold at which the second is 0.95. That threshold is
chosen with the labels at hand. What to expect of other pictures is told by the set cut in five, in
the order of names, for neighbours are often alike: each fifth with the threshold of the other four.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.lab.bench.rows import Row
from rotorpong.lab.eye_settings import colour_named
from rotorpong.lab.picture_sets import PictureSet, read_picture_sets
from rotorpong.vision.colour import Colour
from rotorpong.vision.detect import Detection, detect, find_balls
from rotorpong.vision.pictures import hush_codecs

PRECISION = 0.95
OVERLAP = 0.5
FOLDS = 5
USUAL = ("orange", "orange,white")  # to look for, each by itself
PIXEL_CENTER = 0.5  # boxes count from the picture's edge, detections from the first pixel's centre

Boxes = Float[ndarray, "n 4"]  # left, top, right, bottom
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Matches:
    """The detections of some pictures, in falling order of score."""

    score: Float[ndarray, "n"]
    right: Bool[ndarray, "n"]
    overlap: Float[ndarray, "n"]  # with the box it took, nan if none
    away_px: Float[ndarray, "n"]  # from that box's centre
    diameter_ratio: Float[ndarray, "n"]  # diameter over the box's mean side
    balls: int  # labelled


def rows(
    folder: Path,
    progress: Progress,
    *,
    ball_class: int | None = None,
    colour: str | None = None,
) -> tuple[Row, ...]:
    """Return how well balls are found in each set of pictures.

    Args:
        folder: of pictures and labels, or of such folders.
        progress: called with (pictures done, pictures).
        ball_class: of a ball, where labels are of several classes.
        colour: to look for, as `rotorpong detect` takes it; by default each of `USUAL`.

    Raises:
        InputError: see `require`, or a damaged picture.
    """
    sets, searches = require(folder, ball_class, colour)
    hush_codecs()
    total, done, found = sum(len(one.pictures) for one in sets) * len(searches), 0, []
    for one in sets:
        for given, colours in searches.items():
            progress(done, total)
            found += set_rows(f"images: {one.name}, {given}", one, colours)
            done += len(one.pictures)
    progress(total, total)
    return tuple(found)


def require(
    folder: Path, ball_class: int | None, colour: str | None
) -> tuple[tuple[PictureSet, ...], dict[str, list[Colour]]]:
    """Return what `rows` looks through, and what for.

    Raises:
        InputError: see `picture_sets.read_picture_sets`, or an unknown colour.
    """
    searches = USUAL if colour is None else (colour,)
    known = {given: [colour_named(name) for name in given.split(",")] for given in searches}
    return read_picture_sets(folder, ball_class), known


def set_rows(name: str, one: PictureSet, colours: Sequence[Colour | str]) -> list[Row]:
    """Return the rows of a set, looked through for balls of some colours."""
    pictures, quick = [], []
    for labelled in one.pictures:
        picture, boxes = labelled.read()
        pictures.append(match(detect(picture, colours), boxes))
        quick.append(match(find_balls(picture, colours), boxes))
    return [
        Row(f"{name}: pictures", len(pictures), "pictures"),
        *score_rows(name, pictures),
        Row(f"{name}: recall of the quick search", recall_of(quick), "1"),
        *place_rows(name, pooled(pictures)),
    ]


def recall_of(pictures: Sequence[Matches]) -> float:
    """Return the recall at the precision that is asked for."""
    every = pooled(pictures)
    return at_threshold(every, threshold_at(every, PRECISION))[0]


def score_rows(name: str, pictures: Sequence[Matches]) -> list[Row]:
    """Return the rows about what is found and what is not."""
    every = pooled(pictures)
    threshold = threshold_at(every, PRECISION)
    recall, precision = at_threshold(every, threshold)
    held_recall, held_precision = held_out(pictures)
    found = [
        Row(f"{name}: balls", every.balls, "balls"),
        Row(f"{name}: recall at precision {PRECISION:g}", recall, "1"),
        Row(f"{name}: precision there", precision, "1"),
        Row(f"{name}: held-out recall", held_recall, "1"),
        Row(f"{name}: held-out precision", held_precision, "1"),
        Row(f"{name}: average precision", average_precision(every), "1"),
    ]
    if np.isfinite(threshold):
        found.insert(3, Row(f"{name}: least score there", threshold, "1"))
    return found


def place_rows(name: str, every: Matches) -> list[Row]:
    """Return the rows about where balls are found, if any is."""
    right = every.right
    if not right.any():
        return []
    return [
        Row(f"{name}: overlap, median", float(np.median(every.overlap[right])), "1"),
        Row(f"{name}: centre error, median", float(np.median(every.away_px[right])), "px"),
        Row(f"{name}: diameter ratio, median", float(np.median(every.diameter_ratio[right])), "1"),
    ]


def match(detections: Sequence[Detection], boxes: Boxes) -> Matches:
    """Return which detections of a picture are right: each box is taken once, best score first."""
    ordered = sorted(detections, key=lambda one: -one.score)
    free = np.ones(len(boxes), bool)
    found = np.full((len(ordered), 3), np.nan)
    for i, one in enumerate(ordered):
        shares = np.where(free, overlaps(one, boxes), 0.0)
        best = int(np.argmax(shares)) if len(shares) else -1
        if best >= 0 and shares[best] >= OVERLAP:
            free[best] = False
            left, top, right, bottom = boxes[best]
            x, y = one.x_px + PIXEL_CENTER, one.y_px + PIXEL_CENTER
            away = np.hypot(x - (left + right) / 2, y - (top + bottom) / 2)
            side = (right - left + bottom - top) / 2
            found[i] = shares[best], away, one.diameter_px / side
    scores = np.array([one.score for one in ordered], float)
    return Matches(scores, np.isfinite(found[:, 0]), *found.T, balls=len(boxes))


def overlaps(one: Detection, boxes: Boxes) -> Float[ndarray, "n"]:
    """Return intersection over union of a detection's square with each box."""
    center = np.array([one.x_px, one.y_px]) + PIXEL_CENTER
    first, last = center - one.diameter_px / 2, center + one.diameter_px / 2
    sides = np.minimum(boxes[:, 2:], last) - np.maximum(boxes[:, :2], first)
    both = np.prod(np.maximum(sides, 0.0), axis=1)
    return both / (one.diameter_px**2 + np.prod(boxes[:, 2:] - boxes[:, :2], axis=1) - both)


def pooled(pictures: Sequence[Matches]) -> Matches:
    """Return the detections of all pictures as those of one."""
    fields = ("score", "right", "overlap", "away_px", "diameter_ratio")
    columns = [np.concatenate([getattr(one, field) for one in pictures]) for field in fields]
    order = np.argsort(-columns[0], kind="stable")
    return Matches(*(column[order] for column in columns), balls=sum(p.balls for p in pictures))


def threshold_at(found: Matches, precision: float) -> float:
    """Return the lowest score down to which detections are as often right; infinity if none is."""
    share = np.cumsum(found.right) / np.arange(1, len(found.right) + 1)
    whole = np.append(found.score[1:] < found.score[:-1], True)[: len(share)]  # not within a tie
    good = np.flatnonzero((share >= precision) & whole)
    return float(found.score[good[-1]]) if len(good) else np.inf


def at_threshold(found: Matches, threshold: float) -> tuple[float, float]:
    """Return recall and precision of the detections from a score up; precision 1 without any."""
    return _recall_and_precision([(found, threshold)])


def held_out(pictures: Sequence[Matches]) -> tuple[float, float]:
    """Return recall and precision of every part with the threshold that the others need."""
    number = min(FOLDS, len(pictures))
    part = np.arange(len(pictures)) * number // len(pictures)
    tried = []
    for k in range(number):
        others = [one for one, at in zip(pictures, part, strict=True) if at != k]
        threshold = threshold_at(pooled(others), PRECISION) if others else np.inf
        tried.append(
            (pooled([one for one, at in zip(pictures, part, strict=True) if at == k]), threshold)
        )
    return _recall_and_precision(tried)


def _recall_and_precision(parts: Sequence[tuple[Matches, float]]) -> tuple[float, float]:
    right = sum(int(found.right[found.score >= least].sum()) for found, least in parts)
    detected = sum(int(np.sum(found.score >= least)) for found, least in parts)
    balls = sum(found.balls for found, _ in parts)
    return right / max(balls, 1), right / detected if detected else 1.0


def average_precision(found: Matches) -> float:
    """Return the area under precision over recall, precision made to fall with recall."""
    if not found.balls:
        return 0.0
    share = np.cumsum(found.right) / np.arange(1, len(found.right) + 1)
    envelope = np.maximum.accumulate(share[::-1])[::-1]
    return float(np.sum(envelope[found.right]) / found.balls)

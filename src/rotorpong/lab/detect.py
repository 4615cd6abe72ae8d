"""Balls in the user's own pictures: what `rotorpong detect` does."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong.conventions import BALL_DIAMETER, InputError
from rotorpong.lab.spec import camera_named, require_choice
from rotorpong.vision.colour_files import read_colour
from rotorpong.vision.detect import COLOURS, Colour
from rotorpong.vision.pictures import (
    PictureBalls,
    as_json,
    detect_pictures,
    hush_codecs,
    write_annotated,
)

EYES = ("paper",)
LARGEST_BALL = 1.0  # m


@dataclass(frozen=True, slots=True)
class Search:
    """What is looked for in the pictures."""

    camera: str | None = None  # profile or calibration file that took them; None: no positions
    eyes: str = "paper"
    colours: tuple[str, ...] = ("orange",)  # names, or files of `calibrate colour`
    ball_diameter: float = BALL_DIAMETER  # m
    min_score: float = 0.0  # 0 to 1


def detect_all(
    paths: Sequence[Path], search: Search, out: Path | None, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    """Find balls in pictures, folders and videos.

    Args:
        paths: of all of them.
        search: what to look for, and how.
        out: folder for annotated pictures; None: none are written.
        progress: called with (pictures done, pictures done).

    Returns:
        What `detect --json` prints.

    Raises:
        InputError: an unknown name, a ball of no size, an unreadable or empty path, or `out` is
            no folder.
    """
    require_choice("eyes", search.eyes, EYES)
    if not 0.0 < search.ball_diameter < LARGEST_BALL:
        raise InputError(
            f"ball diameter {1000 * search.ball_diameter:g} mm: expected above 0 and below "
            f"{1000 * LARGEST_BALL:g} mm"
        )
    colours = _colours(search.colours)
    if out is not None and out.exists() and not out.is_dir():
        raise InputError(f"out {str(out)!r} is a file: expected a folder for annotated pictures")
    hush_codecs()
    found = detect_pictures(
        paths,
        camera=None if search.camera is None else camera_named(search.camera),
        colours=colours,
        ball_diameter=search.ball_diameter,
        min_score=search.min_score,
    )
    return as_json(_kept(found, out, progress))


def _colours(given: Sequence[str]) -> tuple[Colour, ...]:
    """Return the colours of names and files; what is asked for twice is looked for once."""
    colours = tuple(dict.fromkeys(map(_colour, given)))
    names = [colour.name for colour in colours]
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"colours {','.join(given)}: {names.count(name)} of them are named {name!r}; "
                "expected names that differ (see the field `name` in the file)"
            )
    return colours


def _colour(given: str) -> Colour:
    if given in COLOURS:
        return COLOURS[given]
    if not (given and Path(given).exists()):
        require_choice("colour", given, tuple(COLOURS), "or a file of `calibrate colour`")
    return read_colour(given)


def _kept(
    found: Iterator[PictureBalls], out: Path | None, progress: Callable[[int, int], None]
) -> Iterator[PictureBalls]:
    for index, result in enumerate(found):
        if out is not None:
            write_annotated(result, out, index=index)
        progress(index + 1, index + 1)
        yield result

"""Balls in the user's own pictures: what `rotorpong detect` does."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from rotorpong.conventions import BALL_DIAMETER, InputError
from rotorpong.files import target_of
from rotorpong.lab.choices import require_choice
from rotorpong.lab.eye_settings import (
    CIRCLE_FITS,
    DIAMETERS,
    EyeSettings,
    colour_named,
    require_effect,
)
from rotorpong.lab.spec import camera_named
from rotorpong.vision.colour import Colour
from rotorpong.vision.films import CODECS, Film, film
from rotorpong.vision.located import StillEyes
from rotorpong.vision.marks import annotate, draw_trails, make_folder, write_annotated
from rotorpong.vision.pictures import (
    PictureBalls,
    as_json,
    frame_rate,
    hush_codecs,
    is_video,
    linked,
    look_at,
)

EYES = ("paper", "tracker")
LARGEST_BALL = 1.0  # m
TRAIL_S = 1.0  # how far back a trail goes

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Search:
    """What is looked for in the pictures."""

    camera: str | None = None  # profile or calibration file that took them; None: no positions
    eyes: str = "paper"
    colours: tuple[str, ...] = ("orange",)  # names, or files of `calibrate colour`
    ball_diameter: float = BALL_DIAMETER  # m
    min_score: float = 0.0  # 0 to 1
    circle_fit: str | None = None  # of the paper's eyes
    diameter: str | None = None  # of the paper's eyes: whole pixels or, if not asked for, not


def detect_all(
    paths: Sequence[Path], search: Search, out: Path | None, progress: Progress
) -> dict[str, Any]:
    """Find balls in pictures, folders and videos.

    Args:
        paths: of all of them.
        search: what to look for, and how.
        out: where marked pictures and films go: a folder, or the film of one video; None: nowhere.
        progress: called with (pictures done, pictures done).

    Returns:
        What `detect --json` prints.

    Raises:
        InputError: an unknown name, a ball of no size, an unreadable or empty path, or `out` is
            no place for what would be written.
    """
    eyes = _still_eyes(search)
    if out is not None:
        _check_out(out, paths)
    hush_codecs()
    found = look_at(paths, eyes)
    if search.eyes == "tracker":
        found = linked(found, search.ball_diameter)
    with _Gallery(out) as gallery:
        return as_json(_kept(found, gallery, progress))


def _still_eyes(search: Search) -> StillEyes:
    """Return what looks at the pictures, everything checked."""
    require_choice("eyes", search.eyes, EYES)
    settings = EyeSettings(search.circle_fit, search.diameter)
    require_effect(settings, search.eyes)
    if search.circle_fit is not None:
        require_choice("circle fit", search.circle_fit, CIRCLE_FITS)
    if search.diameter is not None:
        require_choice("diameter", search.diameter, DIAMETERS)
    if not 0.0 < search.ball_diameter < LARGEST_BALL:
        raise InputError(
            f"ball diameter {1000 * search.ball_diameter:g} mm: expected above 0 and below "
            f"{1000 * LARGEST_BALL:g} mm"
        )
    return StillEyes(
        None if search.camera is None else camera_named(search.camera),
        _colours(search.colours),
        search.ball_diameter,
        search.min_score,
        fine=search.eyes == "tracker",
        fit=settings.fit,
        whole_pixels=search.diameter == "whole",
    )


def _colours(given: Sequence[str]) -> tuple[Colour, ...]:
    """Return the colours of names and files; what is asked for twice is looked for once."""
    colours = tuple(dict.fromkeys(map(colour_named, given)))
    names = [colour.name for colour in colours]
    for name in names:
        if names.count(name) > 1:
            raise InputError(
                f"colours {','.join(given)}: {names.count(name)} of them are named {name!r}; "
                "expected names that differ (see the field `name` in the file)"
            )
    return colours


def _check_out(out: Path, paths: Sequence[Path]) -> None:
    """Refuse a place for marked pictures that is none, before anything is looked at."""
    if not _is_film(out):
        if out.exists() and not out.is_dir():
            raise InputError(
                f"out {str(out)!r} is a file: expected a folder for annotated pictures, or for one "
                f"video the name of a film ({', '.join(CODECS)})"
            )
        return
    if len(paths) != 1 or not (is_video(paths[0]) and paths[0].is_file()):
        raise InputError(
            f"out {str(out)!r} is one film: expected one video to look at, or a folder for out"
        )
    if target_of(out).exists() and os.path.samefile(out, paths[0]):
        raise InputError(f"out {str(out)!r} is the video that is looked at; expected another name")


def _is_film(out: Path) -> bool:
    return out.suffix.lower() in CODECS and not out.is_dir()


def _kept(
    found: Iterator[PictureBalls], gallery: "_Gallery", progress: Progress
) -> Iterator[PictureBalls]:
    for index, result in enumerate(found):
        gallery.show(result, index)
        progress(index + 1, index + 1)
        yield result
    gallery.finish()


class _Gallery:
    """Where marked pictures and films go; a context manager."""

    def __init__(self, out: Path | None) -> None:
        self._out = out
        self._open = ExitStack()
        self._film: Film | None = None
        self._source: Path | None = None  # of the film that is being written
        self._trail = 1  # frames
        self._next = 0  # frame of it

    def __enter__(self) -> "_Gallery":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.__exit__(kind, error, trace)

    def show(self, result: PictureBalls, index: int) -> None:
        """Write a picture, or the next frame of a film."""
        if self._out is None:
            return
        tracks = result.tracks or ()
        if not is_video(result.path):
            write_annotated(result, self._out, index=index, tracks=tracks)
            return
        if self._source != result.path or result.frame != self._next:
            self.finish()
            self._begin(result.path, self._out, index)
        marked = annotate(result.picture, result.balls, tracks)
        seen = [track for track in tracks if track is not None and track.number is not None]
        draw_trails(marked, seen, self._trail)
        self._next = result.frame + 1
        if self._film is not None:
            self._film.write(marked)

    def finish(self) -> None:
        """Give the film its place."""
        self._open.close()
        self._film = self._source = None

    def _begin(self, source: Path, out: Path, index: int) -> None:
        rate = frame_rate(source)
        self._source, self._trail = source, max(1, round(TRAIL_S * rate))
        path = out if _is_film(out) else make_folder(out) / f"{index:05d}-{source.stem}.mp4"
        self._film = self._open.enter_context(film(path, rate))

"""One serve as a film, an animation or a contact sheet: onboard and from beside the table.

The serve is trial `index` of an evaluation with the same seed, frame by frame. Suffixes decide:
`.mp4` a film, `.gif` an animation, `.png` a sheet of moments.
"""

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from rotorpong.conventions import InputError, Picture
from rotorpong.drone import Player
from rotorpong.experience import shipped_demonstrations
from rotorpong.files import replacing, target_of
from rotorpong.lab.evaluate import Knowledge, player_of
from rotorpong.lab.footage import play_again
from rotorpong.lab.report.cinema import (
    FRAME_SIZE,
    LOST,
    MARKS,
    VERDICTS,
    Scenery,
    contact_sheet,
    shot,
)
from rotorpong.lab.spec import Spec, own_player, require_count
from rotorpong.lab.trial import stage_of
from rotorpong.vision.films import film

Progress = Callable[[int, int], None]
Pictures = Iterator[Picture]

SUFFIXES = (".mp4", ".gif", ".png")
FILM_FPS, ANIMATION_FPS = 30.0, 20.0
HELD_S = 1.2  # how long the last picture stays
ANIMATION_WIDTH = 900  # px
ANIMATION_COLOURS = 160
MOMENTS, COLUMNS = 8, 4  # of a contact sheet
SLOWEST = 100.0


def throw(
    spec: Spec,
    index: int,
    out: Path,
    *,
    slow: float = 4.0,
    knowledge: Knowledge | None = None,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Play serve `index` and write what it looked like; return what `throw --json` prints.

    Args:
        spec: what is played.
        index: of the serve.
        out: file to write, by its suffix a film, an animation or a contact sheet.
        slow: how many times slower than life; a contact sheet knows no time.
        knowledge: what a player that learns starts from.
        progress: called with (done, pictures).

    Raises:
        InputError: an unknown suffix, a place that cannot be written, a negative index, or a speed
            out of range.
    """
    check(index, out, slow)
    stage = stage_of(spec)
    take = play_again(stage, index, _player(spec, knowledge))
    scenery = Scenery(stage, take)
    tell = progress or (lambda done, total: None)
    with replacing(out) as path:
        frames = _WRITERS[out.suffix.lower()](path, scenery, slow, tell)
    return {
        "outcome": take.played.outcome,
        "miss_distance_m": take.played.miss_distance,
        "frames": frames,
        "out": str(out),
    }


def check(index: int, out: Path, slow: float) -> None:
    """Raise InputError if no such serve can be written there."""
    require_count("index", index, least=0)
    if not (math.isfinite(slow) and 1.0 <= slow <= SLOWEST):
        raise InputError(f"slow {slow:g}: expected a number from 1 to {SLOWEST:g}")
    if out.suffix.lower() not in SUFFIXES:
        raise InputError(f"{out}: expected a name that ends with {', '.join(SUFFIXES)}")
    target_of(out)


def _player(spec: Spec, knowledge: Knowledge | None) -> Player:
    if spec.is_own_player:
        return own_player(spec.player)()
    return player_of(spec, knowledge or Knowledge(shipped_demonstrations()))


def _shots(scenery: Scenery, fps: float, slow: float, tell: Progress) -> Pictures:
    """Yield the pictures of a film: the serve, then its end for a while."""
    count = math.ceil(scenery.duration * slow * fps)
    for k in range(count):
        yield shot(scenery, k / (slow * fps))
        tell(k, count)
    last = shot(scenery, scenery.duration, ended=True)
    yield from (last for _ in range(round(HELD_S * fps)))
    tell(count, count)


def _write_film(path: Path, scenery: Scenery, slow: float, tell: Progress) -> int:
    with film(path, FILM_FPS) as made:
        for picture in _shots(scenery, FILM_FPS, slow, tell):
            made.write(picture)
    return made.frames


def _write_animation(path: Path, scenery: Scenery, slow: float, tell: Progress) -> int:
    palette = _palette(scenery)
    images = [
        _small(picture).quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in _shots(scenery, ANIMATION_FPS, slow, tell)
    ]
    first, *others = images
    pause = round(1000 / ANIMATION_FPS)
    first.save(path, save_all=True, append_images=others, duration=pause, loop=0, optimize=False)
    return len(images)


def _palette(scenery: Scenery) -> Image.Image:
    """Return colours for all pictures: those of some, and of the marks, which are small in them."""
    shots = [shot(scenery, share * scenery.duration) for share in (0.3, 0.6, 1.0)]
    marks = np.array([*MARKS, *VERDICTS.values(), LOST, scenery.take.setting.scene.ball])
    swatches = np.repeat(marks.astype(np.uint8)[None, :, None], 80, axis=0).repeat(80, axis=2)
    strip = np.zeros((80, FRAME_SIZE[0], 3), np.uint8)
    strip[:, : 80 * len(marks)] = swatches.reshape(80, -1, 3)
    stacked = np.vstack([*shots, strip])
    return Image.fromarray(stacked[..., ::-1].copy()).quantize(ANIMATION_COLOURS)


def _small(picture: Picture) -> Image.Image:
    height = round(picture.shape[0] * ANIMATION_WIDTH / picture.shape[1])
    size = (ANIMATION_WIDTH, height)
    return Image.fromarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA)[..., ::-1])


def _write_sheet(path: Path, scenery: Scenery, slow: float, tell: Progress) -> int:
    moments = np.linspace(0.0, scenery.duration, MOMENTS + 1)[1:]
    sheet = contact_sheet(scenery, moments, COLUMNS)
    written, data = cv2.imencode(".png", sheet)
    if not written:
        raise InputError(f"{path.parent}: this OpenCV cannot write PNG")
    path.write_bytes(data.tobytes())
    tell(MOMENTS, MOMENTS)
    return MOMENTS


_WRITERS = {".mp4": _write_film, ".gif": _write_animation, ".png": _write_sheet}

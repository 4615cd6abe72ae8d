"""A calibration file from a folder of chessboard pictures: what `rotorpong calibrate camera` does.

The file is plain JSON, or YAML as ROS keeps `camera_info`; `read_camera` reads either back to the
last digit.
"""

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.files import target_of, write_whole
from rotorpong.physics.camera import LEAST_AND_MOST, Camera
from rotorpong.vision.chessboard import LEAST_BOARDS, Board, Corners, find_corners, fit_lens
from rotorpong.vision.pictures import PICTURE_SUFFIXES, hush_codecs, read_picture

SUFFIXES = (".json", ".yaml", ".yml")
CORNERS = (3, 50)  # least and most of a board, each way
LARGEST_SQUARE_MM = 1000.0

Progress = Callable[[int, int], None]


@dataclass(slots=True)
class _Seen:
    """What the pictures of a folder showed."""

    used: list[str] = field(default_factory=list)
    without_board: list[str] = field(default_factory=list)
    unreadable: list[str] = field(default_factory=list)
    corners: list[Corners] = field(default_factory=list)
    size: tuple[int, int] | None = None  # width and height of all of them, px


def calibrate_camera(
    folder: Path, out: Path, board: Board, progress: Progress, *, frames_per_second: float = 30.0
) -> dict[str, Any]:
    """Write the calibration of the camera that took the pictures in a folder.

    Args:
        folder: of pictures of the board; other files are passed over.
        out: FILE.json, .yaml or .yml.
        board: that they show.
        progress: called with (pictures done, of how many).
        frames_per_second: of the camera, for the file.

    Returns:
        What `calibrate camera --json` prints.

    Raises:
        InputError: nothing to read, `out` cannot be written, fewer than three boards, pictures of
            several sizes, or boards that do not tell the lens.
    """
    if out.suffix.lower() not in SUFFIXES:
        raise InputError(f"out {str(out)!r}: expected a name that ends in {', '.join(SUFFIXES)}")
    least, most = LEAST_AND_MOST["frames_per_second"]
    if not least <= frames_per_second <= most:
        raise InputError(f"frames per second {frames_per_second}; expected {least:g} to {most:g}")
    target_of(out)  # nothing is searched for a place that cannot be written
    hush_codecs()
    seen = _look(folder, board, progress)
    if len(seen.used) < LEAST_BOARDS or seen.size is None:
        raise InputError(_too_few(folder, board, seen))
    name = re.sub(r"[^\w.-]", "_", out.stem)
    blank = Camera(name, *seen.size, (1.0, 1.0), (0.0, 0.0), frames_per_second=frames_per_second)
    try:
        fit = fit_lens(seen.corners, board, blank)
    except InputError as error:
        raise InputError(f"{folder}: {len(seen.used)} boards: {error}") from None
    write_whole(out, _file(fit.camera, out.suffix.lower()).encode())
    return {
        "out": str(out),
        "name": name,
        "board": f"{board.columns}x{board.rows}",
        "square_mm": 1000.0 * board.square_m,
        "width_px": seen.size[0],
        "height_px": seen.size[1],
        "frames_per_second": frames_per_second,
        "pictures_used": seen.used,
        "pictures_without_board": seen.without_board,
        "pictures_unreadable": seen.unreadable,
        "reprojection_rms_px": fit.reprojection_rms_px,
        "focal_length_px": list(fit.camera.focal_length_px),
        "focal_length_sd_px": list(fit.focal_length_sd_px),
        "center_px": list(fit.camera.center_px),
        "center_sd_px": list(fit.center_sd_px),
        "distortion": list(fit.camera.distortion),
        "distortion_sd": list(fit.distortion_sd),
        "field_of_view_deg": list(fit.field_of_view_deg),
    }


def board_from(text: str, square_mm: float) -> Board:
    """Return the board of a text like `9x6`: inner corners, columns x rows.

    Raises:
        InputError: it is no such text, or too few or many, or a square of no size.
    """
    least, most = CORNERS
    match = re.fullmatch(r"([0-9]{1,4})[xX]([0-9]{1,4})", text)
    columns, rows = (int(number) for number in match.groups()) if match else (0, 0)
    if not (least <= columns <= most and least <= rows <= most):
        raise InputError(
            f"board {text[:40]!r}; expected its inner corners as COLUMNSxROWS, {least} to {most} "
            "each, such as 9x6 for a board of 10 x 7 squares"
        )
    if not (math.isfinite(square_mm) and 0.0 < square_mm <= LARGEST_SQUARE_MM):
        raise InputError(f"square {square_mm:g} mm; expected above 0, up to {LARGEST_SQUARE_MM:g}")
    return Board(columns, rows, square_mm / 1000.0)


def _look(folder: Path, board: Board, progress: Progress) -> _Seen:
    """Search all pictures of a folder for the board."""
    paths = _pictures(folder)
    seen = _Seen()
    for index, path in enumerate(paths):
        progress(index, len(paths))
        try:
            picture = read_picture(path)
        except InputError:
            seen.unreadable.append(path.name)
            continue
        size = (picture.shape[1], picture.shape[0])
        if seen.size not in (None, size):
            raise InputError(
                f"{path}: {size[0]} x {size[1]} pixels, where those before have "
                f"{seen.size[0]} x {seen.size[1]}; expected pictures of one camera and size"
            )
        seen.size = size
        corners = find_corners(picture, board)
        if corners is None:
            seen.without_board.append(path.name)
        else:
            seen.corners.append(corners)
            seen.used.append(path.name)
    progress(len(paths), len(paths))
    return seen


def _pictures(folder: Path) -> list[Path]:
    if not folder.is_dir():
        what = "is no folder" if folder.exists() else "no such folder"
        raise InputError(f"{folder}: {what}; expected a folder of chessboard pictures")
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: cannot be read ({error.strerror})") from None
    paths = [p for p in entries if p.suffix.lower() in PICTURE_SUFFIXES and p.is_file()]
    if not paths:
        raise InputError(
            f"folder {folder} holds no picture, {len(entries)} other entries; expected chessboard "
            f"pictures: {' '.join(sorted(PICTURE_SUFFIXES))}"
        )
    return paths


def _too_few(folder: Path, board: Board, seen: _Seen) -> str:
    return (
        f"{folder}: {len(seen.used)} pictures show a whole board of {board.columns} x {board.rows} "
        f"inner corners, {len(seen.without_board)} none, {len(seen.unreadable)} cannot be read; "
        f"expected at least {LEAST_BOARDS} (is --board right? it counts corners, not squares)"
    )


def _file(camera: Camera, suffix: str) -> str:
    """Return the text of a calibration file."""
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    if suffix == ".json":
        fields: dict[str, Any] = {"name": camera.name}
        fields |= {"width": camera.width_px, "height": camera.height_px}
        fields |= {"fx": fx, "fy": fy, "cx": cx, "cy": cy}
        fields |= zip(("k1", "k2", "p1", "p2", "k3"), camera.distortion, strict=True)
        fields["frames_per_second"] = camera.frames_per_second
        return json.dumps(fields, indent=2, allow_nan=False) + "\n"
    lines = [f"image_width: {camera.width_px}", f"image_height: {camera.height_px}"]
    lines.append(f'camera_name: "{camera.name}"')
    lines += _matrix("camera_matrix", 3, (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0))
    lines.append("distortion_model: plumb_bob")
    lines += _matrix("distortion_coefficients", 1, camera.distortion)
    lines += _matrix("rectification_matrix", 3, (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    projection = (fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0)
    lines += _matrix("projection_matrix", 3, projection)
    lines.append(f"frames_per_second: {camera.frames_per_second}")
    return "\n".join(lines) + "\n"


def _matrix(name: str, rows: int, numbers: tuple[float, ...]) -> list[str]:
    listed = ", ".join(map(repr, numbers))
    return [f"{name}:", f"  rows: {rows}", f"  cols: {len(numbers) // rows}", f"  data: [{listed}]"]

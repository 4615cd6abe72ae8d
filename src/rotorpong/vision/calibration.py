"""The user's own camera, from the calibration files that tools write.

Three layouts, recognised by their keys; keys are compared in lower case:

- OpenCV `FileStorage`, YAML or JSON: `camera_matrix`, `distortion_coefficients` (each with `rows`,
  `cols`, `data`), `image_width`, `image_height`;
- ROS `camera_info` YAML: the same keys, `distortion_model: plumb_bob`;
- plain JSON: `fx fy cx cy width height`, optionally `k1 k2 p1 p2 k3` and `name`.

Each may also say how the camera sits, sees and sends, in the fields of `Camera` (docs/cameras.md);
what it does not say is ideal. Plain JSON holds nothing else. Other tools' files hold much, which is
passed over, but not what nearly is one of these fields.

Distortion is k1 k2 p1 p2 [k3]; further coefficients must be zero. The YAML reader knows mappings of
scalars, lists and mappings, the two tags OpenCV writes, and nothing else of YAML.
"""

import difflib
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from rotorpong.conventions import InputError
from rotorpong.physics.camera import LEAST_AND_MOST, Camera, require_camera
from rotorpong.vision.fields import without_doubles

LARGEST_FILE = 4 * 2**20  # bytes
DEEPEST_INDENT = 64  # columns
LARGEST_SIDE_PX = 16384
LONGEST_NAME = 255  # of a camera: as long as the name of its file may be
FOCAL_LENGTHS = (0.1, 100.0)  # of the picture's width: 157 to 0.6 degrees
PLAIN_KEYS = ("fx", "fy", "cx", "cy", "width", "height")
PLAIN_DISTORTION = ("k1", "k2", "p1", "p2", "k3")
MATRIX_KEYS = ("camera_matrix", "distortion_coefficients", "image_width", "image_height")
VECTORS = {"delay_s": 2, "position_m": 3}
SENSOR_FIELDS = (*LEAST_AND_MOST, *VECTORS)  # how the camera sits, sees and sends
FARTHEST = 1.0  # m from the body's centre of mass, each axis
NEARLY = 0.8  # likeness of a field's name to one of ours
DISTORTION_MODELS = ("plumb_bob", "rational_polynomial")  # the second where its extra terms are 0

Fields = dict[str, Any]


def read_camera(path: str | Path) -> Camera:
    """Return the camera that a calibration file describes.

    Raises:
        InputError: the file cannot be read, is in no known layout, lacks a field, or its numbers
            are no camera's.
    """
    path = Path(path)
    try:
        fields = _fields(_text(path))
        camera = _camera(fields, path.stem)
        check_camera(camera)
    except InputError as error:
        raise InputError(f"calibration {path}: {error}") from None
    except RecursionError:
        raise InputError(f"calibration {path}: is nested too deeply") from None
    return camera


def check_camera(camera: Camera) -> None:
    """Refuse what no calibration of a camera on a drone is.

    Raises:
        InputError: focal length, centre, lens, or what it says of the sensor cannot be.
    """
    least, most = (limit * camera.width_px for limit in FOCAL_LENGTHS)
    if not all(least <= focal <= most for focal in camera.focal_length_px):
        raise InputError(
            f"focal lengths {camera.focal_length_px} px for a picture {camera.width_px} px wide; "
            f"expected {least:g} to {most:g} (pixels, not millimetres)"
        )
    x, y = camera.center_px
    if not (0 <= x <= camera.width_px and 0 <= y <= camera.height_px):
        raise InputError(
            f"centre ({x:g}, {y:g}) lies outside the picture of "
            f"{camera.width_px} x {camera.height_px} pixels: calibrated at another size?"
        )
    _check_sensor(camera)


def _text(path: Path) -> str:
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
        text = data.decode("utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError("is not text; expected YAML or JSON") from None
    if len(data) > LARGEST_FILE:
        raise InputError(f"is larger than {LARGEST_FILE} bytes")
    return text


def _fields(text: str) -> Fields:
    """Return the top-level fields, keys in lower case."""
    if text.lstrip().startswith("{"):
        fields = _json(text)
    else:
        lines = [line for line in text.splitlines() if _has_content(line)]
        if any(_indent(line) > DEEPEST_INDENT for line in lines):
            raise RecursionError
        fields = _yaml(lines)
    if not isinstance(fields, dict) or not fields:
        raise InputError("holds no fields; expected OpenCV or ROS YAML, or JSON")
    return without_doubles([(str(key).lower(), value) for key, value in fields.items()])


def _json(text: str) -> Any:
    try:
        return json.loads(text, object_pairs_hook=without_doubles)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"is damaged JSON ({error})") from None


def _has_content(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(("#", "%YAML", "---", "..."))


def _yaml(lines: list[str]) -> Fields:
    """Return the mapping of lines of one indent; deeper lines belong to the key above them."""
    pairs: list[tuple[str, Any]] = []
    at = 0
    while at < len(lines):
        key, colon, rest = lines[at].partition(":")
        end = at + 1
        while end < len(lines) and _is_below(lines[end], _indent(lines[at])):
            end += 1
        if not colon or not key.strip() or _indent(lines[at]) != _indent(lines[0]):
            raise InputError(f"is damaged YAML at {lines[at].strip()[:40]!r}")
        name = key.strip().strip("\"'")
        pairs.append((name, _yaml_value(rest.strip(), lines[at + 1 : end])))
        at = end
    return without_doubles(pairs)


def _is_below(line: str, indent: int) -> bool:
    """Tell whether a line belongs to the key above it; items of its list need not be indented."""
    return _indent(line) > indent or line[indent:].startswith("- ")


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _yaml_value(rest: str, below: list[str]) -> Any:
    value = re.sub(r"^!!\S+\s*", "", rest)
    if value.startswith(("[", "{")):
        return _flow(" ".join([value, *below]))
    if not below:
        return _scalar(value)
    first = below[0].lstrip()
    if first.startswith("- "):
        return [_scalar(line.lstrip().removeprefix("-").strip()) for line in below]
    return _flow(" ".join(below)) if first.startswith(("[", "{")) else _yaml(below)


def _flow(text: str) -> Any:
    """Return a list or mapping in brackets, as JSON after putting its numbers and keys right."""
    text = re.sub(r"(?<![\w.])([+-]?)(\d+)\.(?=[\s,\]}eE])", r"\1\2.0", text)
    text = re.sub(r"(?<![\w.])([+-]?)\.(?=\d)", r"\g<1>0.", text).replace("+", "")
    return _json(re.sub(r"([{,]\s*)([A-Za-z_]\w*)\s*:", r'\1"\2":', text))


def _scalar(text: str) -> Any:
    text = text.partition(" #")[0].strip()  # a comment may follow
    try:
        return float(text)
    except ValueError:
        return text.strip("\"'")


def _camera(fields: Fields, name: str) -> Camera:
    lens = _matrix_camera if "camera_matrix" in fields else _plain_camera
    said: Fields = {key: _number(fields[key], key) for key in LEAST_AND_MOST if key in fields}
    for key in VECTORS.keys() & fields.keys():
        said[key] = _vector(fields[key], key)
    return replace(lens(fields, name), **said)


def _matrix_camera(fields: Fields, name: str) -> Camera:
    _require(fields, MATRIX_KEYS)
    _refuse_misspelt(fields)
    model = fields.get("distortion_model", "plumb_bob")
    if model not in DISTORTION_MODELS or fields.get("fisheye_model", 0):
        raise InputError(f"distortion model {model!r}, fisheye or not; expected plumb_bob")
    matrix = _numbers(fields["camera_matrix"], "camera_matrix")
    if not _is_pinhole(matrix, fields["camera_matrix"]):
        raise InputError(f"camera_matrix {matrix}; expected fx 0 cx, 0 fy cy, 0 0 1 as 3 x 3")
    return Camera(
        _name(fields.get("camera_name", name)),
        _side(fields["image_width"], "image_width"),
        _side(fields["image_height"], "image_height"),
        (matrix[0], matrix[4]),
        (matrix[2], matrix[5]),
        _distortion(_numbers(fields["distortion_coefficients"], "distortion_coefficients")),
    )


def _plain_camera(fields: Fields, name: str) -> Camera:
    _require(fields, PLAIN_KEYS)
    known = (*PLAIN_KEYS, *PLAIN_DISTORTION, "name", *SENSOR_FIELDS)
    unknown = sorted(set(fields) - set(known))
    if unknown:
        raise InputError(f"unknown fields {', '.join(unknown)}; known are {', '.join(known)}")
    fx, fy, cx, cy = (_number(fields[key], key) for key in PLAIN_KEYS[:4])
    return Camera(
        _name(fields.get("name", name)),
        _side(fields["width"], "width"),
        _side(fields["height"], "height"),
        (fx, fy),
        (cx, cy),
        _distortion([_number(fields.get(key, 0.0), key) for key in PLAIN_DISTORTION]),
    )


def _require(fields: Fields, keys: tuple[str, ...]) -> None:
    missing = [key for key in keys if key not in fields]
    if missing:
        raise InputError(
            f"lacks {', '.join(missing)}; it has {', '.join(sorted(fields))[:200]}; expected "
            f"{', '.join(MATRIX_KEYS)} (OpenCV, ROS) or {', '.join(PLAIN_KEYS)} (plain JSON)"
        )


def _refuse_misspelt(fields: Fields) -> None:
    for key in sorted(fields.keys() - set(SENSOR_FIELDS)):
        if meant := difflib.get_close_matches(key, SENSOR_FIELDS, 1, NEARLY):
            raise InputError(f"unknown field {key}; expected {meant[0]}")


def _vector(value: Any, name: str) -> tuple[float, ...]:
    """Return the numbers of a list, or of a matrix."""
    given = value.get("data") if isinstance(value, dict) else value
    if not isinstance(given, list) or len(given) != VECTORS[name]:
        raise InputError(f"{name} is {str(given)[:40]}; expected a list of {VECTORS[name]} numbers")
    return tuple(_number(number, name) for number in given)


def _numbers(value: Any, name: str) -> list[float]:
    """Return a matrix' numbers, row by row; it must have as many as its shape says."""
    if not isinstance(value, dict) or not isinstance(value.get("data"), list):
        raise InputError(f"{name} must be a matrix with rows, cols and data")
    numbers = [_number(number, name) for number in value["data"]]
    shape = [_number(value.get(key), f"{name}.{key}") for key in ("rows", "cols")]
    if len(numbers) != shape[0] * shape[1]:
        raise InputError(f"{name} has {len(numbers)} numbers for {shape[0]:g} x {shape[1]:g}")
    return numbers


def _is_pinhole(numbers: list[float], matrix: Fields) -> bool:
    square = matrix["rows"] == matrix["cols"] == 3
    return square and [numbers[k] for k in (1, 3, 6, 7, 8)] == [0, 0, 0, 0, 1]


def _name(value: Any) -> str:
    """Return what a camera is called; the stem of its file's name may be anything."""
    name = f"{value:g}" if isinstance(value, float) else value
    if not isinstance(name, str) or len(name) > LONGEST_NAME:
        raise InputError(f"name is {str(name)[:40]!r}; expected text, up to {LONGEST_NAME} letters")
    return "".join(letter if letter.isprintable() else "_" for letter in name)


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not _is_finite(value):
        raise InputError(f"{name} is {str(value)[:40]!r}; expected a finite number")
    return float(value)


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number of hundreds of digits
        return False


def _side(value: Any, name: str) -> int:
    side = _number(value, name)
    if side != int(side) or not 1 <= side <= LARGEST_SIDE_PX:
        raise InputError(f"{name} is {side:g}; expected whole pixels, 1 to {LARGEST_SIDE_PX}")
    return int(side)


def _distortion(numbers: list[float]) -> tuple[float, float, float, float, float]:
    if len(numbers) < 4 or any(numbers[5:]):
        raise InputError(
            f"distortion coefficients {numbers}; expected k1 k2 p1 p2 [k3], any further ones 0"
        )
    k1, k2, p1, p2, k3 = (*numbers, 0.0)[:5]
    return k1, k2, p1, p2, k3


def _check_sensor(camera: Camera) -> None:
    """Refuse what no camera on a drone is: out of range, slower than its own frames, far away."""
    require_camera(camera)
    interval = 1.0 / camera.frames_per_second
    for name in ("readout_s", "exposure_s"):
        if getattr(camera, name) > interval:
            raise InputError(
                f"{name} is {getattr(camera, name):g}; expected at most {interval:.4g}, for at "
                f"{camera.frames_per_second:g} frames per second the next one begins then"
            )
    if max(map(abs, camera.position_m)) > FARTHEST:
        raise InputError(
            f"position_m is {camera.position_m}; expected forward, left and up of the centre of "
            f"mass, at most {FARTHEST:g} (metres, not millimetres)"
        )

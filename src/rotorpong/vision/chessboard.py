"""A camera's lens from pictures of a chessboard, by Zhang's method as OpenCV has it.

The board's inner corners lie on a plane at known places; in every picture they are found to a
fraction of a pixel. Focal lengths, centre, distortion k1 k2 p1 p2 k3 and the board's place in each
picture are those that least squares of the corners' distances in pixels gives. How surely follows
from the curvature there: standard deviations come with the numbers.

k3 stays only where the boards tell it from 0, for in r^7 it makes much of a little noise where no
board was. Boards that are all parallel tell depth and focal length only together, and boards in the
middle do not tell what the lens does at the border: both are refused, as is a fit that leaves more
than a blurred corner would.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import cv2
import numpy as np
from jaxtyping import Float, Float32
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.physics.camera import Camera, directions
from rotorpong.vision.calibration import check_camera

LEAST_BOARDS = 3
LEAST_TURN_DEG = 8.0  # between the two boards that differ most; parallel ones tell no depth
MOST_ERROR_PX = 2.0  # rms, of a picture 1000 px wide; a sharp board has 0.1 to 0.5
MOST_FOCAL_SD = 0.02  # of the focal length
MOST_CENTER_SD = 0.02  # of the picture's width
K3_SDS = 3.0  # standard deviations from 0, below which k3 is left out
LEAST_SPAN = 0.6  # of the picture's width and height, from the first corner to the last
LONGEST_SEARCHED_PX = 1280  # a larger picture is searched smaller: it would take minutes
CORNER_WINDOW = 0.35  # of the distance between corners: no other corner is in the window
LARGEST_WINDOW_PX = 11
STOP = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-4)
FLAGS = cv2.CALIB_CB_ADAPTIVE_THRESH + cv2.CALIB_CB_NORMALIZE_IMAGE
ADVICE = "expected boards tilted by 20 to 40 degrees in different directions, all over the picture"

Corners = Float32[ndarray, "_ 2"]


@dataclass(frozen=True, slots=True)
class Board:
    """A chessboard: how many inner corners it has, and how far apart."""

    columns: int
    rows: int
    square_m: float

    @property
    def points(self) -> Float32[ndarray, "n 3"]:
        """Where the corners are on the board, m, row by row."""
        down, across = np.mgrid[: self.rows, : self.columns]
        flat = np.stack([across, down, np.zeros_like(down)], axis=-1).reshape(-1, 3)
        return (flat * self.square_m).astype(np.float32)


@dataclass(frozen=True, slots=True)
class LensFit:
    """A lens, and how well the boards tell it."""

    camera: Camera
    reprojection_rms_px: float
    focal_length_sd_px: tuple[float, float]
    center_sd_px: tuple[float, float]
    distortion_sd: tuple[float, ...]  # 0 of a k3 that is left out

    @property
    def field_of_view_deg(self) -> tuple[float, float]:
        """Angle from the middle of the left edge to that of the right one; from top to bottom."""
        return field_of_view_deg(self.camera)


def find_corners(picture: Picture, board: Board) -> Corners | None:
    """Return where the board's inner corners are in a picture, px; `None` if it shows no board."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    size = (board.columns, board.rows)
    shrink = max(1.0, max(grey.shape) / LONGEST_SEARCHED_PX)
    small = (
        grey
        if shrink == 1.0
        else cv2.resize(grey, None, fx=1 / shrink, fy=1 / shrink, interpolation=cv2.INTER_AREA)
    )
    found, corners = cv2.findChessboardCorners(small, size, flags=FLAGS)
    if not found:
        return None
    corners = ((corners + 0.5) * shrink - 0.5).astype(np.float32)
    grid = corners.reshape(board.rows, board.columns, 2)
    apart = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    window = int(np.clip(CORNER_WINDOW * apart, 1, LARGEST_WINDOW_PX))
    refined = cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), STOP)
    return refined.reshape(-1, 2)


def fit_lens(corners: Sequence[Corners], board: Board, camera: Camera) -> LensFit:
    """Return `camera` with the lens that the boards tell.

    Args:
        corners: of each picture, px.
        board: that was shown.
        camera: its picture size is that of the pictures; its lens is ignored.

    Raises:
        InputError: too few boards, or boards that do not tell the lens.
    """
    if len(corners) < LEAST_BOARDS:
        raise InputError(f"{len(corners)} boards; expected at least {LEAST_BOARDS}")
    _require_span(corners, camera)
    solution = _solve(corners, board, camera, flags=0)
    if not _is_k3_told(solution.fit):
        solution = _solve(corners, board, camera, flags=cv2.CALIB_FIX_K3)
    _require_told(solution)
    try:
        check_camera(solution.fit.camera)
    except InputError as error:
        raise InputError(f"the boards tell a lens that is none ({error}); {ADVICE}") from None
    return solution.fit


def field_of_view_deg(camera: Camera) -> tuple[float, float]:
    """Return the angles between the middles of opposite edges: across, down."""
    (x, y), right, bottom = camera.center_px, camera.width_px - 0.5, camera.height_px - 0.5
    edges = np.array([[-0.5, y], [right, y], [x, -0.5], [x, bottom]])
    rays = np.degrees(np.arctan(directions(camera, edges)))
    return float(rays[1, 0] - rays[0, 0]), float(rays[3, 1] - rays[2, 1])


@dataclass(frozen=True, slots=True)
class _Solution:
    fit: LensFit
    normals: Float[ndarray, "n 3"]  # of the boards, in the camera frame


def _solve(corners: Sequence[Corners], board: Board, camera: Camera, *, flags: int) -> _Solution:
    points = [board.points] * len(corners)
    size = (camera.width_px, camera.height_px)
    try:
        rms, matrix, lens, turns, _, spread, *_ = cv2.calibrateCameraExtended(
            points,
            list(corners),
            size,
            None,  # pyright: ignore[reportArgumentType, reportCallIssue]
            None,  # pyright: ignore[reportArgumentType]
            flags=flags,
        )
    except cv2.error:
        raise InputError(f"the boards found tell no lens; {ADVICE}") from None
    k1, k2, p1, p2, k3 = lens.ravel()[:5].tolist()
    sd = spread.ravel()[:9].tolist()
    found = replace(
        camera,
        focal_length_px=(float(matrix[0, 0]), float(matrix[1, 1])),
        center_px=(float(matrix[0, 2]), float(matrix[1, 2])),
        distortion=(k1, k2, p1, p2, k3),
    )
    fit = LensFit(found, float(rms), (sd[0], sd[1]), (sd[2], sd[3]), tuple(sd[4:]))
    return _Solution(fit, np.array([cv2.Rodrigues(turn)[0][:, 2] for turn in turns]))


def _require_span(corners: Sequence[Corners], camera: Camera) -> None:
    """Refuse boards that leave the rest of the picture, where the lens bends most, to guessing."""
    span = np.ptp(np.concatenate(corners), axis=0) / (camera.width_px, camera.height_px)
    if not span.min() >= LEAST_SPAN:
        raise InputError(
            f"all boards together span {100 * span[0]:.0f} % of the picture's width and "
            f"{100 * span[1]:.0f} % of its height, which leaves the lens beyond to guessing; "
            f"expected at least {100 * LEAST_SPAN:g} %: boards near every border, or nearer"
        )


def _is_k3_told(fit: LensFit) -> bool:
    """Tell whether k3 differs from 0 and the lens with it can be undone."""
    if abs(fit.camera.distortion[4]) < K3_SDS * fit.distortion_sd[4]:
        return False
    try:
        check_camera(fit.camera)
    except InputError:
        return False
    return True


def _require_told(solution: _Solution) -> None:
    """Refuse a fit of boards that do not tell the lens."""
    fit, camera = solution.fit, solution.fit.camera
    most = MOST_ERROR_PX * max(camera.width_px / 1000.0, 1.0)
    if not fit.reprojection_rms_px <= most:
        raise InputError(
            f"corners lie {fit.reprojection_rms_px:.2f} px (rms) from where the lens puts them; "
            f"expected at most {most:g}: sharp pictures of one flat board by one camera"
        )
    turn = _largest_turn_deg(solution.normals)
    if not turn >= LEAST_TURN_DEG:
        raise InputError(
            f"all boards are parallel within {turn:.1f} degrees, which tells no focal length; "
            f"{ADVICE}"
        )
    focal = max(np.divide(fit.focal_length_sd_px, camera.focal_length_px))
    center = max(fit.center_sd_px) / camera.width_px
    if not (focal <= MOST_FOCAL_SD and center <= MOST_CENTER_SD):
        raise InputError(
            f"the boards tell the focal length to {100 * focal:.1f} % and the centre to "
            f"{100 * center:.1f} % of the width only (standard deviations; at most "
            f"{100 * MOST_FOCAL_SD:g} and {100 * MOST_CENTER_SD:g}); {ADVICE}"
        )


def _largest_turn_deg(normals: Float[ndarray, "n 3"]) -> float:
    cosines = [abs(float(one @ other)) for one, other in combinations(normals, 2)]
    return float(np.degrees(np.arccos(min(min(cosines), 1.0))))

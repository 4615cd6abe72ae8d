"""The film strip: onboard frames with what the eyes found drawn in, as JPEG inside the page.

An estimate is drawn by reading Eqs. (1) and (2) backwards: the circle stands where the eyes say the
ball is, as large as a ball there would look. A loupe in the corner shows the ball enlarged.
"""

import base64
from dataclasses import dataclass

import cv2
import numpy as np
from numpy import ndarray

from rotorpong.conventions import BALL_DIAMETER, Picture
from rotorpong.lab.footage import Sight, Take
from rotorpong.physics.camera import GAZEBO, Camera, in_picture, project

FRAMES = 8
QUALITY = 88  # of JPEG
MARK = (255, 0, 255)  # blue, green, red: magenta, which no ball has
WHITE = (255, 255, 255)
LOUPE_PX = 132
ZOOM = 4
MARGIN = 8
FINE = 4  # binary digits behind the point in which OpenCV draws


@dataclass(frozen=True, slots=True)
class FilmFrame:
    """A frame of the strip."""

    jpeg: str  # data URI
    width: int
    height: int
    time: float  # s
    estimated_distance: float | None  # m
    true_distance: float  # m
    is_trigger: bool

    def as_json(self) -> dict[str, float | None]:
        """Return the numbers of the frame."""
        return {
            "time_s": self.time,
            "estimated_distance_m": self.estimated_distance,
            "true_distance_m": self.true_distance,
        }


def film_strip(take: Take, count: int = FRAMES) -> tuple[FilmFrame, ...]:
    """Return frames from the first sight of the ball to the last, the trigger among them."""
    trigger = take.trigger
    at = [i for i, sight in enumerate(take.sights) if _is_at(sight, trigger)]
    return tuple(
        _frame(take.sights[i], is_trigger=i in at) for i in _chosen(take.sights, at[:1], count)
    )


def poster(take: Take) -> FilmFrame:
    """Return the frame that stands at the head of the page: the ball well in sight."""
    seen = [sight for sight in take.sights if sight.estimate is not None] or list(take.sights)
    return _frame(seen[len(seen) // 2], is_trigger=False)


def _is_at(sight: Sight, trigger: object) -> bool:
    return trigger is not None and sight.estimate is trigger


def _chosen(sights: tuple[Sight, ...], always: list[int], count: int) -> list[int]:
    """Return evenly spread places among the frames that show the ball, the trigger's for one."""
    visible = [i for i, sight in enumerate(sights) if _shows_ball(sight)]
    if not visible:
        visible = list(range(len(sights)))
    spread = np.linspace(0, len(visible) - 1, min(count, len(visible)))
    places = [visible[round(float(place))] for place in spread]
    for wanted in always:
        nearest = min(range(len(places)), key=lambda k: abs(places[k] - wanted))
        places[nearest] = wanted
    return places


def _shows_ball(sight: Sight) -> bool:
    return sight.estimate is not None or bool(in_picture(GAZEBO, sight.ball))


def _frame(sight: Sight, *, is_trigger: bool) -> FilmFrame:
    estimate = sight.estimate
    picture = sight.observation.frame.picture.copy()
    height, width = picture.shape[:2]
    if estimate is not None:
        picture = _marked(picture, estimate.position)
    return FilmFrame(
        _data_uri(picture),
        width,
        height,
        sight.observation.frame_time,
        None if estimate is None else float(np.linalg.norm(estimate.position)),
        float(np.linalg.norm(sight.ball)),
        is_trigger,
    )


def _marked(picture: Picture, position: ndarray) -> Picture:
    center, radius = circle_in_picture(GAZEBO, position)
    loupe = _loupe(picture, center, radius)
    marked = picture.copy()
    _circle(marked, center, max(radius + 4.0, 9.0), 2)
    left = MARGIN if center[0] > picture.shape[1] / 2 else picture.shape[1] - LOUPE_PX - MARGIN
    top = picture.shape[0] - LOUPE_PX - MARGIN
    marked[top : top + LOUPE_PX, left : left + LOUPE_PX] = loupe
    corner = (left + LOUPE_PX - 1, top + LOUPE_PX - 1)
    cv2.rectangle(marked, (left, top), corner, WHITE, 2, cv2.LINE_AA)
    return marked


def circle_in_picture(camera: Camera, position: ndarray) -> tuple[ndarray, float]:
    """Return centre and radius in pixels of the circle that gave `position` by Eqs. (1), (2)."""
    distance = float(np.linalg.norm(position))
    return project(camera, position), camera.focal_length_px[0] * BALL_DIAMETER / distance / 2


def _loupe(picture: Picture, center: ndarray, radius: float) -> ndarray:
    """Return the surroundings of the ball enlarged, less so when it is near, with its circle."""
    zoom = min(float(ZOOM), 0.38 * LOUPE_PX / radius)
    middle = (LOUPE_PX - 1) / 2
    shift = np.array([[zoom, 0, middle - zoom * center[0]], [0, zoom, middle - zoom * center[1]]])
    size = (LOUPE_PX, LOUPE_PX)
    loupe = cv2.warpAffine(picture, shift, size, flags=cv2.INTER_CUBIC, borderValue=(40, 40, 40))
    _circle(loupe, np.array([middle, middle]), radius * zoom, 2)
    return loupe


def _circle(picture: ndarray, center: ndarray, radius: float, thickness: int) -> None:
    scale = 1 << FINE
    x, y = (round(float(value) * scale) for value in center)
    cv2.circle(picture, (x, y), round(radius * scale), MARK, thickness, cv2.LINE_AA, FINE)


def _data_uri(picture: ndarray) -> str:
    _, jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(jpeg.tobytes()).decode("ascii")

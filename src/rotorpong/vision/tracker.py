"""Eyes that follow the ball: search, predict, look where it must be, measure, estimate.

    navdata -> own motion ----------------------------.
    frame -> box about the prediction -> candidates -> sight -> flight filter -> BallEstimate

Nothing known: the whole picture is searched, and each of the best candidates starts a track of its
own. From then on a track reads of every frame only the box in which the ball must be (4 standard
deviations and the ball itself), takes of the candidates there the one with the least NIS, and
refuses all if none is within the gate: it then coasts. A track that misses too often ends; what is
told is the track that saw the ball most often. A thing that stands still, or that a hand holds,
does not fall, so its track ends within a few frames.

After each sight of a flight that may have bounced since the last, both histories are tried: the
one with the smaller NIS stays.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import BALL_RADIUS, InputError, Picture, Vector3
from rotorpong.drone import BallEstimate, Box, Frame, Observation
from rotorpong.physics.camera import Camera, camera_from_body, project, row_time
from rotorpong.vision.detect import as_picture, find_balls
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    Belief,
    Crossing,
    Prior,
    Sight,
    begin,
    crossing,
    ground,
    place,
    predict,
    read_level,
    update,
)
from rotorpong.vision.matte import BALL_COLOURS, Guess, measure_ball, region_around
from rotorpong.vision.own_motion import OwnMotion, Reading
from rotorpong.vision.sphere import SpherePositions, outline_shape, sphere_of_disc

MOST_TRACKS = 4
GATE = 16.3  # chi-square of 3 degrees, 99.9 %
RENEWALS = (2, 3, 4, 5, 7, 10, 14, 20, 28)  # sights, at which all of them are fitted at once
CONFIRMED = 4  # sights after which a track is believed to be a ball
MOST_MISSES, MOST_BLIND = 2, 10  # frames in a row, before and after that
BOX_SIGMAS, BOX_MARGIN_PX = 4.0, 8.0
LEAST_SCORE = 0.05
MOST_CANDIDATES = 4  # of a frame, measured
SENSOR_FACTOR, SENSOR_SD_PX = 2.0, 0.04
"""What a disc's covariance leaves out where the sensor is no ideal one: edges behind the ball,
noise that hangs together, the shutter. Chosen by NIS and NEES of `bench eyes` (1.03 and 1.07 of
what they should be over 30 serves at 720p; 1.45 and 4.5 without)."""
NEAREST = 0.15  # m


@dataclass(slots=True)
class _Track:
    """One thing that may be the ball."""

    belief: Belief
    sights: list[Sight]
    missed: int = 0
    nis: list[float] = field(default_factory=list)

    @property
    def is_confirmed(self) -> bool:
        return len(self.sights) >= CONFIRMED

    @property
    def is_lost(self) -> bool:
        return self.missed > (MOST_BLIND if self.is_confirmed else MOST_MISSES)


class TrackerEyes:
    """Eyes for one serve."""

    def __init__(
        self,
        camera: Camera,
        *,
        home: Sequence[float],
        prior: Prior = HUMAN_PRIOR,
        colours: Sequence[str] = ("orange",),
    ) -> None:
        """Look through `camera`.

        Args:
            camera: whose frames these are.
            home: where the body hovers at the release, m, origin in the middle of the table.
            prior: what is known of serve, air, table and attitude.
            colours: of balls.
        """
        self._camera, self._prior = camera, prior
        self._colours = tuple(colours)
        self._motion = OwnMotion(np.array(home, dtype=float))
        self._axes = camera_from_body(camera)
        self._ground = ground(prior, 0.0)
        self._tracks: list[_Track] = []

    def see(self, observation: Observation) -> BallEstimate | None:
        """Return the ball in the camera frame at the frame's time, with its covariance.

        Raises:
            InputError: the frame is not of this camera's size.
        """
        frame, time = observation.frame, float(observation.frame_time)
        if (frame.width, frame.height) != (self._camera.width_px, self._camera.height_px):
            raise InputError(
                f"a frame of {frame.width} x {frame.height} pixels; camera {self._camera.name} "
                f"has {self._camera.width_px} x {self._camera.height_px}"
            )
        self._level(self._motion.add(observation.navdata))
        for track in self._tracks:
            self._follow(track, frame, time)
        self._tracks = [track for track in self._tracks if not track.is_lost]
        if self.is_searching:
            self._search(frame, time)
        best = self._best
        return None if best is None or best.missed else self._told(best.belief)

    @property
    def _best(self) -> _Track | None:
        """The track that saw its ball most often, and at least twice."""
        seen = [track for track in self._tracks if len(track.sights) > 1]
        return max(seen, key=lambda track: len(track.sights), default=None)

    @property
    def belief(self) -> Belief | None:
        """What is known of the ball, table frame, at the time of the last frame."""
        return None if self._best is None else self._best.belief

    def crossing(self, normal: Vector3, offset: float) -> Crossing | None:
        """Return where the ball will pass the plane normal . p = offset (table frame, m)."""
        belief = self.belief
        return None if belief is None else crossing(belief, normal, offset, self._prior)

    @property
    def nis(self) -> list[float]:
        """NIS of each sight of the ball but the first."""
        return [] if self._best is None else list(self._best.nis)

    @property
    def is_searching(self) -> bool:
        """Whether the next frame is searched as a whole."""
        return not any(track.is_confirmed for track in self._tracks)

    def place_of_drone(self, time: float) -> Vector3:
        """Return where odometry has the body at a time (s), table frame, m."""
        return self._motion.pose(time)[0]

    def _level(self, reading: Reading | None) -> None:
        if reading is None:
            return
        quality = self._prior.attitude
        sd = quality.reading_sd / math.sqrt(max(1.0, reading.duration * quality.reading_rate))
        self._ground = read_level(self._ground, reading.angles, reading.heading, sd)
        for track in self._tracks:
            track.belief = read_level(track.belief, reading.angles, reading.heading, sd)

    def _follow(self, track: _Track, frame: Frame, time: float) -> None:
        """Take in of a frame what is seen where the ball of a track must be."""
        flown = predict(track.belief, time, self._prior)
        box = self._box(flown)
        found = [] if box is None else self._sights(frame, time, box)
        tried = [(sight, *self._taken(track.belief, sight)) for sight in found]
        best = min(tried, key=lambda one: one[2], default=None)
        if best is not None and best[2] < GATE:
            sight, track.belief, nis = best
            track.missed = 0
            track.sights.append(sight)
            track.nis.append(nis)
            if len(track.sights) in RENEWALS:
                track.belief = begin(self._ground, track.sights, self._prior)
        else:
            track.belief, track.missed = flown, track.missed + 1

    def _taken(self, belief: Belief, sight: Sight) -> tuple[Belief, float]:
        """Return the belief after a sight, and its NIS, by the history that explains it best."""
        told = update(predict(belief, sight.time, self._prior), sight)
        bounced = belief.velocity[2] < 0.0 < told[0].velocity[2]
        if not bounced:
            return told
        flown_on = predict(belief, sight.time, self._prior, bounces=False)
        return min(told, update(flown_on, sight), key=lambda one: one[1])

    def _search(self, frame: Frame, time: float) -> None:
        """Start tracks from what looks like a ball and is no track's yet."""
        whole = (0, 0, frame.width, frame.height)
        room = MOST_TRACKS - len(self._tracks)
        for sight in self._sights(frame, time, whole)[:room]:
            if any(self._is_of(track, sight) for track in self._tracks):
                continue
            start = place(replace(self._ground, time=sight.time), sight)
            belief, _ = update(start, sight)
            self._tracks.append(_Track(belief, [sight]))

    @staticmethod
    def _is_of(track: _Track, sight: Sight) -> bool:
        """Tell whether a track took in this very ball of this frame."""
        last = track.sights[-1]
        apart = np.linalg.norm((last.seen - sight.seen)[:2])
        return track.missed == 0 and bool(apart < last.seen[2] + sight.seen[2])

    def _sights(self, frame: Frame, time: float, box: Box) -> list[Sight]:
        """Return what may be balls in a box of the frame, best first."""
        picture = as_picture(frame.region(*box))
        found = [ball for ball in find_balls(picture, self._colours) if ball.score >= LEAST_SCORE]
        sights = []
        for ball in found[:MOST_CANDIDATES]:
            center = np.array([ball.x_px + box[0], ball.y_px + box[1]])
            shape = outline_shape(self._camera, center)
            guess = Guess(float(center[0]), float(center[1]), ball.diameter_px, shape=shape)
            sights.append(self._measured(picture, guess, ball.colour, box, time))
        return [sight for sight in sights if sight is not None]

    def _measured(
        self, picture: Picture, guess: Guess, colour: str, box: Box, time: float
    ) -> Sight | None:
        """Return the sight of the ball near a guess; `None` if there is none to be measured."""
        x0, y0, x1, y1 = region_around(guess, self._camera.width_px, self._camera.height_px)
        x0, y0 = max(x0, box[0]), max(y0, box[1])
        near = picture[y0 - box[1] : y1 - box[1], x0 - box[0] : x1 - box[0]]
        if not near.size:
            return None
        disc = measure_ball(
            near, guess, BALL_COLOURS[colour], offset=(x0, y0), gamma=self._camera.gamma
        )
        if disc is None:
            return None
        measured = np.array([disc.x_px, disc.y_px, disc.radius_px])
        try:
            sphere = sphere_of_disc(self._camera, measured, self._spread(disc.covariance))
        except InputError:
            return None
        at = float(row_time(self._camera, time, np.array(disc.y_px)))
        return self._sight(at, sphere)

    def _spread(self, covariance: Float[ndarray, "3 3"]) -> Float[ndarray, "3 3"]:
        """Return the covariance of a disc with what a real sensor adds, px^2."""
        if self._camera.is_ideal:
            return covariance
        return SENSOR_FACTOR * covariance + SENSOR_SD_PX**2 * np.eye(3)

    def _sight(self, time: float, sphere: SpherePositions) -> Sight:
        """Return a ball in the camera's frame as an angle, seen from where the camera was."""
        x, y, z = sphere.position
        squared = float(sphere.position @ sphere.position)
        sine = BALL_RADIUS / math.sqrt(squared)
        slopes = np.array([[1.0 / z, 0.0, -x / z**2], [0.0, 1.0 / z, -y / z**2], np.zeros(3)])
        slopes[2] = -sine / (squared * math.sqrt(1.0 - sine**2)) * sphere.position
        noise = slopes @ sphere.covariance @ slopes.T
        noise[:2, :2] += self._prior.attitude.jitter_sd**2 * np.eye(2)
        body, turned = self._motion.pose(time)
        eye = body + turned @ np.array(self._camera.position_m)
        seen = np.array([x / z, y / z, math.asin(sine)])
        return Sight(time, seen, noise, eye, self._axes @ turned.T)

    def _view(self, belief: Belief) -> tuple[Vector3, Float[ndarray, "3 3"]]:
        """Return place of the camera and rotation to it from the table frame, tilt included."""
        body, turned = self._motion.pose(belief.time)
        x, y, z = belief.tilt
        tilt = np.array([[1.0, z, -y], [-z, 1.0, x], [y, -x, 1.0]])
        eye = body + turned @ np.array(self._camera.position_m)
        return eye, self._axes @ turned.T @ tilt

    def _box(self, belief: Belief) -> Box | None:
        """Return where in the picture the ball must be; `None` if it is out of it."""
        eye, rotation = self._view(belief)
        ball = rotation @ (belief.position - eye)
        if ball[2] < NEAREST:
            return None
        pixel = project(self._camera, ball)
        spread = rotation @ belief.covariance[:3, :3] @ rotation.T
        focal = self._camera.focal_length_px[0]
        radius = focal * BALL_RADIUS / ball[2]
        roll, pitch, _ = belief.tilt_sd
        sd = focal / ball[2] * np.sqrt(np.diag(spread)[:2]) + focal * np.array([pitch, roll])
        half = BOX_SIGMAS * sd + 2.0 * radius + BOX_MARGIN_PX
        if not np.all(np.isfinite([*pixel, *half])):
            return None
        low = np.maximum(np.floor(pixel - half), 0).astype(int)
        size = (self._camera.width_px, self._camera.height_px)
        high = np.minimum(np.ceil(pixel + half) + 1, size).astype(int)
        if np.any(high - low < 2):
            return None
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    def _told(self, belief: Belief) -> BallEstimate:
        """Return a belief in the camera's frame."""
        eye, rotation = self._view(belief)
        turn = np.kron(np.eye(2), rotation)
        position = rotation @ (belief.position - eye)
        velocity = rotation @ (belief.velocity - self._motion.velocity(belief.time))
        covariance = turn @ belief.covariance[:6, :6] @ turn.T
        return BallEstimate(belief.time, position, velocity, covariance)

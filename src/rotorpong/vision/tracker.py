"""Eyes that follow the ball: search, predict, look where it must be, measure, estimate.

    navdata -> own motion --------------------------.
    frame -> disc where the ball must be -> sight -> flight filter -> BallEstimate

Nothing known: the whole picture is searched, and each of the best candidates starts a track of its
own. From then on a track predicts the ball's disc, its streak and how the rolling shutter bends it
(`sights.Aim`), and measures there at once where it is sure by a third of a radius. If it is not, or
if what it finds there is beyond the gate, it looks for candidates in the box in which the ball must
be (4 standard deviations and the ball itself) and takes the one with the least NIS. A sight beyond
the gate is still taken if one flight fitted to all sights explains it along with them: the filter
was too sure of itself. Else it is refused and the track coasts. A track that misses too often ends;
what is told is the track that saw the ball most often. A thing that stands still, or that a hand
holds, does not fall, so its track ends within a few frames.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError, Picture, Rotation, Vector3
from rotorpong.drone import BallEstimate, Box, Frame, Observation
from rotorpong.physics.camera import Camera, camera_from_body, row_time
from rotorpong.vision._flight_filter_kernels import LEVEL, TILT
from rotorpong.vision.colour import Colour, as_colour
from rotorpong.vision.detect import (
    LARGE_PICTURE_PIXELS,
    Detection,
    as_picture,
    detect,
    find_balls,
)
from rotorpong.vision.flight_filter import (
    HUMAN_PRIOR,
    Belief,
    Crossing,
    Prior,
    Sight,
    begun,
    crossing,
    ground,
    place,
    predict,
    read_level,
    renewed,
    seen,
    update,
)
from rotorpong.vision.matte import (
    BallColour,
    BallDisc,
    Guess,
    measure_ball,
    region_around,
    rolling_shape,
    streamed,
    without_rolling,
)
from rotorpong.vision.own_motion import OdometryQuality, OwnMotion, Reading
from rotorpong.vision.paint import paint_of
from rotorpong.vision.sights import Aim, Pose, aim_at, angles_of_disc
from rotorpong.vision.sphere import outline_shape

MOST_TRACKS = 4
GATE = 16.3  # chi-square of 3 degrees, 99.9 %
GATE_SDS = 3.1  # of a chi-square of many degrees, about its mean: 99.9 %
CONFIRMED = 4  # sights after which a track is believed to be a ball
MOST_DROPPED = 32  # places where no track begins again
SAME_PLACE, SAME_SIZE = 2.0, 0.15  # of it: radii apart, relative
MOST_MISSES, MOST_BLIND = 2, 10  # frames in a row, before and after that
BOX_SIGMAS, BOX_MARGIN_PX = 4.0, 8.0
LEAST_SCORE = 0.05
MOST_CANDIDATES = 4  # of a frame, measured
LAG = 0.005  # s, over which the picture's motion is told
DOUBT, UNCHECKED = 0.3, 2.0
"""A disc's covariance grows by 1 + 0.3 d^2, d the disagreement of area and edge; 2 where there is
no area. Rounded from how NEES of discs grows with d over 40 serves of seed 100; the tail that is
left (6 to 8 % beyond the gate at 6 to 14 px before that growth, 720p) is the gate's affair."""
SENSOR_SD_PX, IDEAL_SD_PX = 0.01, 0.02
"""What it leaves out: of a real sensor, and of an ideal one, whose edges of few pixels are coarse:
the latter over the root of the radius. From the same serves."""
FALLING_SD_PX_S = 500.0  # px/s, before a velocity is known
FASTEST = 0.3  # rows that a ball may fall by while one is read out
ODOMETRY = OdometryQuality()


@dataclass(slots=True)
class _Track:
    """One thing that may be the ball."""

    belief: Belief
    sights: list[Sight]
    colour: Colour
    missed: int = 0
    nis: list[float] = field(default_factory=list)

    @property
    def is_confirmed(self) -> bool:
        return len(self.sights) >= CONFIRMED

    def keep(self, belief: Belief, nis: float) -> None:
        """Believe this after a sight of this NIS."""
        self.belief, self.missed = belief, 0
        self.nis.append(nis)

    @property
    def is_lost(self) -> bool:
        return self.missed > (MOST_BLIND if self.is_confirmed else MOST_MISSES)


class _Look(NamedTuple):
    """One frame."""

    frame: Frame
    time: float  # s


class _Motion(NamedTuple):
    """Of a ball in the picture, px/s."""

    across: float = 0.0
    down: float = 0.0
    down_sd: float = FALLING_SD_PX_S


class TrackerEyes:
    """Eyes for one serve."""

    def __init__(
        self,
        camera: Camera,
        *,
        home: Sequence[float],
        prior: Prior = HUMAN_PRIOR,
        odometry: OdometryQuality = ODOMETRY,
        colours: Sequence[Colour | str] = ("orange",),
    ) -> None:
        """Look through `camera`.

        Args:
            camera: whose frames these are.
            home: where the body hovers at the release, m, origin in the middle of the table.
            prior: what is known of serve, air, table and attitude.
            odometry: how well the drone knows its own velocity.
            colours: of balls.

        Raises:
            InputError: an unknown name of a colour.
        """
        self._camera, self._prior = camera, prior
        self._colours = tuple(as_colour(colour) for colour in colours)
        self._motion = OwnMotion(np.array(home, dtype=float), prior.attitude, odometry)
        self._lever = np.array(camera.position_m)
        self._row = camera.readout_s / camera.height_px
        self._axes = camera_from_body(camera)
        self._ground = ground(prior, 0.0)
        self._tracks: list[_Track] = []
        self._dropped: list[Float[ndarray, "3"]] = []  # seen last of tracks that were no ball's

    def see(self, observation: Observation) -> BallEstimate | None:
        """Return the ball in the camera frame when its row was exposed, with its covariance.

        Raises:
            InputError: the frame is not of this camera's size.
        """
        frame = observation.frame
        look = _Look(frame, float(observation.frame_time))
        if (frame.width, frame.height) != (self._camera.width_px, self._camera.height_px):
            raise InputError(
                f"a frame of {frame.width} x {frame.height} pixels; camera {self._camera.name} "
                f"has {self._camera.width_px} x {self._camera.height_px}"
            )
        self._level(self._motion.add(observation.navdata))
        for track in self._tracks:
            self._follow(track, look)
        self._drop_lost()
        if self.is_searching:
            self._search(look)
        best = self._best
        return None if best is None or best.missed else self._told(best.belief)

    def _drop_lost(self) -> None:
        """End tracks that missed too often; what never was a ball starts none there again."""
        lost = [track for track in self._tracks if track.is_lost]
        self._dropped += [track.sights[-1].seen for track in lost if not track.is_confirmed]
        del self._dropped[:-MOST_DROPPED]
        self._tracks = [track for track in self._tracks if not track.is_lost]

    @property
    def _best(self) -> _Track | None:
        """The track that saw its ball most often, and at least twice."""
        seen = [track for track in self._tracks if len(track.sights) > 1]
        return max(seen, key=lambda track: len(track.sights), default=None)

    @property
    def belief(self) -> Belief | None:
        """What is known of the ball, table frame, when it was seen last or the frame was taken."""
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

    def _follow(self, track: _Track, look: _Look) -> None:
        """Take in of a frame what is seen where the ball of a track must be."""
        flown = predict(track.belief, look.time, self._prior)
        aim = self._aim(flown)
        if aim is not None:
            sights = self._aimed(track, look, aim) if aim.is_sure else []
            if self._take(track, sights):
                return
            sights += self._boxed(track, look, aim)
            if self._take(track, sights) or self._reconcile(track, sights):
                return
        track.belief, track.missed = flown, track.missed + 1

    def _take(self, track: _Track, sights: list[Sight]) -> bool:
        """Take in the sight with the least NIS, if it is within the gate."""
        tried = [(sight, *seen(track.belief, sight, self._prior)) for sight in sights]
        best = min(tried, key=lambda one: one[2], default=None)
        if best is None or not best[2] < GATE:
            return False
        sight, belief, nis = best
        track.sights.append(sight)
        belief = renewed(self._ground, belief, track.sights, self._prior)
        track.keep(belief, nis)
        return True

    def _reconcile(self, track: _Track, sights: list[Sight]) -> bool:
        """Take in a sight beyond the gate if one flight explains it with all others."""
        for sight in sights:
            together = [*track.sights, sight]
            belief, levels = begun(self._ground, together, self._prior)
            degrees = 3 * len(together)
            most = degrees + GATE_SDS * math.sqrt(2.0 * degrees)
            if levels[-1] < GATE and levels.sum() < most:
                track.sights.append(sight)
                track.keep(belief, float(levels[-1]))
                return True
        return False

    def _search(self, look: _Look) -> None:
        """Start tracks from what looks like a ball and is no track's yet."""
        frame = look.frame
        whole, motion = (0, 0, frame.width, frame.height), _Motion()
        for sight, colour in self._found(look, whole, motion, self._colours):
            if len(self._tracks) == MOST_TRACKS:
                break
            if any(self._is_of(track, sight) for track in self._tracks):
                continue
            if any(_looks_alike(sight.seen, dropped) for dropped in self._dropped):
                continue
            start = place(replace(self._ground, time=sight.time), sight)
            belief, _ = update(start, sight)
            self._tracks.append(_Track(belief, [sight], colour))

    @staticmethod
    def _is_of(track: _Track, sight: Sight) -> bool:
        """Tell whether a track took in this very ball of this frame."""
        last = track.sights[-1]
        apart = np.linalg.norm((last.seen - sight.seen)[:2])
        return track.missed == 0 and bool(apart < last.seen[2] + sight.seen[2])

    def _aim(self, belief: Belief) -> Aim | None:
        """Return where the ball must be in a picture of its time, the lag of its row allowed."""
        time, camera = belief.time, self._camera
        aim = aim_at(camera, belief, self._pose(time), self._pose(time - LAG), LAG)
        if aim is None or camera.readout_s == 0.0:
            return aim
        across, down = np.clip(aim.velocity_px_s, -FASTEST / self._row, FASTEST / self._row)
        late = (float(row_time(camera, time, np.array(aim.y_px))) - time) / (1.0 - down * self._row)
        x, y = aim.x_px + late * across, aim.y_px + late * down
        return replace(aim, x_px=x, y_px=y, velocity_px_s=(float(across), float(down)))

    def _aimed(self, track: _Track, look: _Look, aim: Aim) -> list[Sight]:
        """Return what is measured at an aim, none or one."""
        motion = _Motion(*aim.velocity_px_s, aim.falling_sd_px_s)
        guess = self._guess((aim.x_px, aim.y_px), 2.0 * aim.radius_px, motion, max(aim.sd_px))
        box = region_around(guess, self._camera.width_px, self._camera.height_px)
        if box[0] >= box[2] or box[1] >= box[3]:
            return []
        picture = as_picture(look.frame.region(*box))
        sight = self._measured(
            picture, guess, track.colour, corner=box[:2], time=look.time, motion=motion
        )
        return [] if sight is None else [sight]

    def _boxed(self, track: _Track, look: _Look, aim: Aim) -> list[Sight]:
        """Return what may be balls in the box where the ball must be, best first."""
        box = self._box(aim)
        if box is None:
            return []
        motion = _Motion(*aim.velocity_px_s, aim.falling_sd_px_s)
        return [sight for sight, _ in self._found(look, box, motion, (track.colour,))]

    def _found(
        self, look: _Look, box: Box, motion: _Motion, colours: Sequence[Colour]
    ) -> list[tuple[Sight, Colour]]:
        """Return what may be balls in a box of the frame, best first, and their colours."""
        picture = as_picture(look.frame.region(*box))
        found = []
        for ball, colour in self._candidates(picture, colours)[:MOST_CANDIDATES]:
            center = ball.x_px + box[0], ball.y_px + box[1]
            guess = self._guess(center, ball.diameter_px, motion, math.inf)
            x0, y0, x1, y1 = region_around(guess, self._camera.width_px, self._camera.height_px)
            x0, y0 = max(x0, box[0]), max(y0, box[1])
            near = picture[y0 - box[1] : y1 - box[1], x0 - box[0] : x1 - box[0]]
            if near.size:
                sight = self._measured(
                    near, guess, colour, corner=(x0, y0), time=look.time, motion=motion
                )
                if sight is not None:
                    found.append((sight, colour))
        return found

    def _candidates(
        self, picture: Picture, colours: Sequence[Colour]
    ) -> list[tuple[Detection, Colour]]:
        """Return what may be balls, best first, and of which colour.

        A ball without a hue is before walls of its own colour, from which no one threshold tells
        it. All are tried where balls are large enough for it.
        """
        is_large = self._camera.width_px * self._camera.height_px > LARGE_PICTURE_PIXELS
        found = [
            (ball, colour)
            for colour in colours
            for ball in (detect if is_large and not colour.has_hue else find_balls)(
                picture, [colour]
            )
            if ball.score >= LEAST_SCORE
        ]
        return sorted(found, key=lambda one: -one[0].score)

    def _guess(
        self, center: tuple[float, float], diameter: float, motion: _Motion, sd: float
    ) -> Guess:
        """Return a ball as it looks: bent by lens and shutter, streaked by its motion."""
        shape = outline_shape(self._camera, np.array(center))
        velocity = np.array(motion[:2])
        if self._row > 0.0:
            shape = rolling_shape(shape, velocity, self._row)
        across, down = (self._camera.exposure_s * velocity).tolist()
        return Guess(*center, diameter, streak_px=(across, down), shape=shape, sd_px=sd)

    def _measured(
        self,
        picture: Picture,
        guess: Guess,
        colour: Colour,
        *,
        corner: tuple[int, int],
        time: float,
        motion: _Motion,
    ) -> Sight | None:
        """Return the sight of the ball near a guess; `None` if there is none to be measured."""
        camera = self._camera
        paint = self._paint(colour)
        disc = measure_ball(picture, guess, paint, offset=corner, gamma=camera.gamma)
        if disc is None:
            return None
        if self._row > 0.0:
            disc = without_rolling(disc, motion.down, self._row)
        measured = np.array([disc.x_px, disc.y_px, disc.radius_px])
        found = angles_of_disc(camera, measured, self._spread(disc, motion.down_sd))
        if found is None:
            return None
        direction, noise = found
        noise[0, 0] += self._prior.attitude.jitter_sd**2
        noise[1, 1] += self._prior.attitude.jitter_sd**2
        at = float(row_time(camera, time, np.array(disc.y_px)))
        pose = self._pose(at)
        return Sight(at, direction, noise, pose[:3], pose[3:].reshape(3, 3))

    def _paint(self, colour: Colour) -> BallColour:
        """Return how balls of a colour are measured in pictures of this camera."""
        paint = paint_of(colour)
        return streamed(paint) if self._camera.stream_mbit_s else paint

    def _spread(self, disc: BallDisc, down_sd: float) -> Float[ndarray, "3 3"]:
        """Return the covariance of a disc with what background, sensor and shutter add, px^2."""
        apart = UNCHECKED if disc.disagreement is None else disc.disagreement
        rest = IDEAL_SD_PX**2 / disc.radius_px if self._camera.is_ideal else SENSOR_SD_PX**2
        spread = (1.0 + DOUBT * apart**2) * disc.covariance + rest * np.eye(3)
        spread[2, 2] += (0.5 * disc.radius_px * down_sd * self._row) ** 2
        return spread

    def _pose(self, time: float) -> Pose:
        """Return place of the camera and rotation to it from the table frame, by the gyro."""
        body, turned = self._motion.pose(time)
        return np.concatenate([body + turned @ self._lever, (self._axes @ turned.T).ravel()])

    def _box(self, aim: Aim) -> Box | None:
        """Return where in the picture the ball must be; `None` if it is out of it."""
        center, size = (aim.x_px, aim.y_px), (self._camera.width_px, self._camera.height_px)
        low, high = [], []
        for axis in range(2):
            half = BOX_SIGMAS * aim.sd_px[axis] + 2.0 * aim.radius_px + BOX_MARGIN_PX
            low.append(max(math.floor(center[axis] - half), 0))
            high.append(min(math.ceil(center[axis] + half) + 1, size[axis]))
            if high[axis] - low[axis] < 2:
                return None
        return low[0], low[1], high[0], high[1]

    def _told(self, belief: Belief) -> BallEstimate:
        """Return a belief in the camera's frame: errors of tilt turn it, and are turned away."""
        pose = self._pose(belief.time)
        told = pose[3:].reshape(3, 3)
        rotation = told - told @ _cross(belief.tilt)
        apart = belief.position - pose[:3]
        closing = belief.velocity - self._motion.velocity(belief.time, self._lever)
        slopes = np.zeros((6, len(belief.mean)))
        slopes[:3, :3] = slopes[3:, 3:6] = rotation
        slopes[:3, TILT:LEVEL], slopes[3:, TILT:LEVEL] = (
            told @ _cross(apart),
            told @ _cross(closing),
        )
        covariance = slopes @ belief.covariance @ slopes.T
        own = np.diag(self._motion.velocity_variance(belief.time))
        covariance[3:, 3:] += rotation @ own @ rotation.T
        return BallEstimate(belief.time, rotation @ apart, rotation @ closing, covariance)


def _looks_alike(one: Float[ndarray, "3"], other: Float[ndarray, "3"]) -> bool:
    """Tell whether two things seen are in one place and of one size: a ball that comes grows."""
    apart = math.hypot(one[0] - other[0], one[1] - other[1])
    return bool(apart < SAME_PLACE * other[2] and abs(one[2] - other[2]) < SAME_SIZE * other[2])


def _cross(vector: Vector3) -> Rotation:
    """Return the matrix that takes w to vector x w."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])

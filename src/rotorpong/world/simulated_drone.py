"""One serve at a simulated drone: the world behind the Drone protocol.

The world ticks at 1 kHz. `observe` lets it run to the arrival of the next frame; a command acts
from the instant at which it is given. Ball and vehicle are flown one after the other: the vehicle
under its command, then the ball among court and vehicle. When the serve is over, and what became of
it, is told by `judging`. What a player gets is an Observation; `truth` is for the laboratory.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.drone import (
    Box,
    Frame,
    Navdata,
    Observation,
    Outcome,
    VelocityCommand,
    Verdict,
)
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.physics.camera import Camera, camera_from_body, require_camera
from rotorpong.physics.vehicle import Track, Vehicle, VehicleState
from rotorpong.world._batch_kernels import FLOWN, fly_leg
from rotorpong.world._contact_kernels import CONTACT_COLUMNS
from rotorpong.world._judging_kernels import HIT, HULL_TOUCHED, WATCH_COLUMNS
from rotorpong.world.contact import (
    MOST_CONTACTS,
    TICK,
    TRACK_LOST,
    BallState,
    Contact,
    Solids,
    contact_from_row,
    require_finite,
    state_of,
)
from rotorpong.world.exposure import Motion, expose
from rotorpong.world.frames import half_exposure, schedule
from rotorpong.world.judging import ENDINGS, LONGEST_SERVE, judge, landing_of
from rotorpong.world.racket import HOME_BODY, Racket
from rotorpong.world.render import Scene, render
from rotorpong.world.sensors import draw_sensors, read
from rotorpong.world.serves import Serve
from rotorpong.world.solids import parameters
from rotorpong.world.stream import Stream

CARDBOARD_RACKET = Racket()
PLAIN_SCENE = Scene()
FIRST_ROW = np.zeros(1, np.int64)
DECIDED = (HIT, HULL_TOUCHED)  # by a contact

Tape = Sequence[tuple[float, VelocityCommand]]  # s, in order


@dataclass(frozen=True, slots=True)
class Truth:
    """What really happened in a serve; world frame, one row per tick from release on."""

    verdict: Verdict
    miss_distance: float  # m, 0 for a hit
    time_error: float | None  # s, positive = the blade was late; 0 for a hit
    landing_x: float | None  # m, where a hit ball first touched the table beyond the net
    ball_path: Float[ndarray, "n 3"]
    body_path: Float[ndarray, "n 3"]
    blade_path: Float[ndarray, "n 3"]
    attitude_path: Float[ndarray, "n 4"]  # quaternions, body to world
    contacts: tuple[Contact, ...]


@dataclass(frozen=True, slots=True)
class Instant:
    """The whole truth at one tick: what decides how the serve goes on."""

    tick: int
    ball: BallState
    vehicle: VehicleState
    solids: Solids


@dataclass(frozen=True, slots=True)
class Setting:
    """What a serve meets: the drone, its camera and racket, and the looks of the room."""

    vehicle: Vehicle
    camera: Camera
    racket: Racket = CARDBOARD_RACKET
    scene: Scene = PLAIN_SCENE
    blackout: bool = False  # every frame is black


class SimulatedDrone:
    """A drone and one serve on its way; implements Drone and Referee."""

    def __init__(
        self,
        serve: Serve,
        setting: Setting,
        *,
        vehicle_rng: np.random.Generator,
        sensor_rng: np.random.Generator,
        tape: Tape = (),
    ) -> None:
        """Hover at home at the instant of release.

        Args:
            serve: the ball.
            setting: everything else.
            vehicle_rng: draws the vehicle's own noise.
            sensor_rng: draws sensor errors, the camera's phase and its delay.
            tape: commands that are given at their times (s), as in a replay.
        """
        self._setting = setting
        self._serve = serve
        camera = require_camera(setting.camera)
        self._solids = Solids(air=serve.air, table=serve.table, racket=setting.racket)
        self._log = _Log(serve, self._solids)
        self._vehicle_state = setting.vehicle.start(np.array(HOME_BODY), vehicle_rng)
        self._limits = setting.vehicle.limits.tolist()
        self._sensors = draw_sensors(setting.vehicle.sensor_noise, sensor_rng)
        camera_rng = sensor_rng.spawn(1)[0]  # noise, jitter, drops: leaves the rest as it was
        self._noise_key = int(camera_rng.integers(2**62))
        exposures, arrivals = schedule(camera, sensor_rng, camera_rng)
        self._frames = iter(zip(exposures.tolist(), arrivals.tolist(), strict=True))
        self._half = half_exposure(camera)
        self._stream = Stream(camera) if camera.stream_mbit_s > 0.0 else None
        self._command, self._new_command = np.zeros(4), True
        self._tape = [(round(time / TICK), velocity) for time, velocity in tape]
        self._end: tuple[Outcome, Contact | None] | None = None
        self.last_navdata: Navdata | None = None  # what came after the last frame

    def observe(self) -> Observation | None:
        """Let the world run until the next frame arrives; `None` when the serve is over."""
        if self._end is not None:
            return None
        exposure, arrival = next(self._frames)
        navdata = self._run(max(arrival - self._log.ticks, 1))
        if self._end is not None:
            self.last_navdata = navdata
            return None
        return Observation(
            frame=self._picture_at(exposure),
            frame_time=exposure * TICK,
            arrival_time=self._log.ticks * TICK,
            navdata=navdata,
        )

    def command(self, velocity: VelocityCommand) -> VelocityCommand:
        """Fly at `velocity` from now on; return it clipped to the vehicle's limits.

        Raises:
            InputError: a component is not finite; the drone goes on as before.
        """
        given = (velocity.forward, velocity.left, velocity.up, velocity.yaw_rate)
        if not all(map(math.isfinite, given)):
            raise InputError(f"command {velocity}: expected finite velocities in m/s and rad/s")
        within = [
            min(max(float(v), -most), most) for v, most in zip(given, self._limits, strict=True)
        ]
        self._command, self._new_command = np.array(within), True
        return VelocityCommand(*within)

    @property
    def camera(self) -> Camera:
        """The onboard camera."""
        return self._setting.camera

    @property
    def vehicle(self) -> Vehicle:
        """Who flies."""
        return self._setting.vehicle

    @property
    def now(self) -> Instant:
        """Where everything is; for the laboratory, as all truth."""
        log = self._log
        return Instant(log.ticks, log.ball[log.ticks].copy(), self._vehicle_state, self._solids)

    @property
    def is_over(self) -> bool:
        """Whether the serve is over."""
        return self._end is not None

    def ball_in_camera(self, time: float) -> tuple[Float[ndarray, "3"], Float[ndarray, "3"]]:
        """Return the true position (m) and velocity (m/s) of the ball in the camera frame."""
        tick = round(time / TICK)
        eye, axes = self._eye(tick)
        before, _ = self._eye(max(tick - 1, 0))
        own_velocity = (eye - before) / TICK
        position, velocity, _ = np.split(self._log.ball[tick], 3)
        return axes.T @ (position - eye), axes.T @ (velocity - own_velocity)

    def verdict(self) -> Verdict:
        """Return what became of the serve, playing it to its end if it is not over."""
        return self.truth().verdict

    def truth(self) -> Truth:
        """Return what really happened, playing the serve to its end if it is not over."""
        while self._end is None:
            self._run(round(1.0 / (self.camera.frames_per_second * TICK)))
        outcome, contact = self._end
        log, racket = self._log, self._setting.racket
        balls, track = log.ball[: log.ticks + 1], log.track[: log.ticks + 1]
        verdict, miss, late = judge(outcome, contact, balls, track, racket)
        return Truth(
            verdict=verdict,
            miss_distance=miss,
            time_error=late,
            landing_x=landing_of(outcome, contact, balls, self._solids),
            ball_path=balls[:, :3].copy(),
            body_path=track[:, :3].copy(),
            blade_path=blade_path(track, racket),
            attitude_path=track[:, 3:].copy(),
            contacts=tuple(log.contacts),
        )

    def _run(self, ticks: int) -> Navdata:
        """Let `ticks` pass, obeying the tape, or less if the serve ends before."""
        goal = min(self._log.ticks + ticks, LONGEST_SERVE)
        parts: list[Navdata] = []
        while self._end is None and self._log.ticks < goal:
            while self._tape and self._tape[0][0] <= self._log.ticks:
                self.command(self._tape.pop(0)[1])
            until = min(goal, self._tape[0][0]) if self._tape else goal
            parts.append(self._leg(until - self._log.ticks))
        return _joined(parts)

    def _leg(self, ticks: int) -> Navdata:
        """Let `ticks` pass under one command."""
        state, track = self._setting.vehicle.advance(
            self._vehicle_state, self._command, ticks=ticks, new_command=self._new_command
        )
        self._vehicle_state, self._new_command = state, False
        start = self._log.ticks
        navdata = read(self._sensors, track, start, departure=start == 0)
        self._end = self._log.fly(track)
        return navdata

    def _picture_at(self, tick: int) -> Frame:
        camera = self.camera
        if self._setting.blackout:
            shape = (camera.height_px, camera.width_px, 3)
            return Frame(camera.width_px, camera.height_px, lambda: np.zeros(shape, np.uint8))
        make = self._sharp(tick) if camera.is_ideal else self._exposed(tick)
        if self._stream is not None:
            return Frame(camera.width_px, camera.height_px, self._stream.send(lambda: make(None)))
        return Frame(camera.width_px, camera.height_px, lambda: make(None), make)

    def _sharp(self, tick: int) -> Callable[[Box | None], Picture]:
        camera, scene = self.camera, self._setting.scene
        pose, ball = self._log.track[tick].copy(), self._log.ball[tick, :3].copy()

        def make(box: Box | None) -> Picture:
            return render(camera, *eye_of(camera, pose), ball, scene, region=box)

        return make

    def _exposed(self, tick: int) -> Callable[[Box | None], Picture]:
        camera, scene, log = self.camera, self._setting.scene, self._log
        first, last = max(tick - self._half, 0), min(tick + self._half, log.ticks)
        track, balls = (rows[first : last + 1].copy() for rows in (log.track, log.ball))
        key = (self._noise_key, tick)

        def make(box: Box | None) -> Picture:
            eyes, axes = eye_of(camera, track)
            motion = Motion(first * TICK, TICK, eyes, axes, balls[:, :3])
            return expose(camera, motion, tick * TICK, scene, key=key, region=box)

        return make

    def _eye(self, tick: int) -> tuple[Float[ndarray, "3"], Float[ndarray, "3 3"]]:
        return eye_of(self.camera, self._log.track[tick])


def eye_of(
    camera: Camera, pose: Float[ndarray, "*n 7"]
) -> tuple[Float[ndarray, "*n 3"], Float[ndarray, "*n 3 3"]]:
    """Return where the camera is and its axes in the world, of body position and quaternion."""
    world_from_body = rotation_from_quaternion(pose[..., 3:])
    eye = pose[..., :3] + world_from_body @ np.array(camera.position_m)
    return eye, world_from_body @ camera_from_body(camera).T


def _joined(parts: list[Navdata]) -> Navdata:
    if len(parts) == 1:
        return parts[0]
    columns = ([getattr(part, f.name) for part in parts] for f in fields(Navdata))
    return Navdata(*(np.concatenate(column) for column in columns))


class _Log:
    """Ball states and poses of every tick so far, kept and flown as a batch of one serve."""

    def __init__(self, serve: Serve, solids: Solids) -> None:
        self._balls = np.empty((1, LONGEST_SERVE + 1, 9))
        self._poses = np.empty((1, LONGEST_SERVE + 1, 7))
        self._watches = np.empty((1, WATCH_COLUMNS))
        self._clocks, self._counts = np.zeros((2, 1), np.int64), np.zeros(1, np.int64)
        self._leg = np.zeros(1, np.int64)
        self._codes, self._deciding = np.zeros(1, np.int64), np.empty((1, CONTACT_COLUMNS))
        self._touched = np.empty((1, MOST_CONTACTS, CONTACT_COLUMNS))
        self._parameters = parameters(solids)[None].copy()  # as the batch's, for one kernel
        self.ball, self.track = self._balls[0], self._poses[0]
        self.contacts: list[Contact] = []
        self.ball[0] = state_of(serve.ball)
        require_finite(self.ball[0])
        self.ticks = 0

    def fly(self, track: Track) -> tuple[Outcome, Contact | None] | None:
        """Fly the ball along what the drone flew.

        Returns:
            How the serve ended and the contact that decided, None if it goes on.

        Raises:
            InputError: a pose is not finite.
        """
        poses = self.track[self.ticks : self.ticks + len(track.position)]
        poses[:, :3], poses[:, 3:] = track.position, track.quaternion
        self._leg[0] = len(poses) - 1
        lost = fly_leg(
            FIRST_ROW,
            self._leg,
            self._parameters,
            self._balls,
            self._poses,
            self._watches,
            self._clocks,
            self._codes,
            self._deciding,
            self._touched,
            self._counts,
        )
        if lost >= 0:
            raise InputError(TRACK_LOST)
        self.ticks = self._clocks.item(FLOWN, 0)
        for row in self._touched[0, : self._counts.item()]:
            self.contacts.append(contact_from_row(row))
        code = self._codes.item()
        outcome = ENDINGS[code]
        if outcome is None:
            return None
        return outcome, contact_from_row(self._deciding[0]) if code in DECIDED else None


def blade_path(track: Float[ndarray, "n 7"], racket: Racket) -> Float[ndarray, "n 3"]:
    """Return where the blade's centre was at each pose, m, world."""
    centre = np.array([racket.x, racket.y, racket.z])
    return track[:, :3] + rotation_from_quaternion(track[:, 3:]) @ centre

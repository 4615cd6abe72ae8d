"""Many serves in lockstep, without pictures and navdata: for learning by millions of trials.

Each row is one serve at one drone, with the noise, the frame times and the rules that
`SimulatedDrone` would give it: same serve, same generators, same commands, same bits. `advance`
lets every row that is not over run to the arrival of its own next frame; the rows' frames differ in
phase and delay, so their clocks differ by less than that. A row that is over can be started again
while the others go on. World frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from jaxtyping import Bool, Float, Int64
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.drone import Outcome
from rotorpong.physics.vehicle import Legs, VehicleState, parts_of, rows_flown_by
from rotorpong.world import _batch_kernels as kernels
from rotorpong.world import _judging_kernels as rules
from rotorpong.world._contact_kernels import CONTACT_COLUMNS
from rotorpong.world.contact import (
    MOST_CONTACTS,
    TRACK_LOST,
    contact_from_row,
    sizes_of,
    state_of,
)
from rotorpong.world.frames import is_regular, most_frames, schedule
from rotorpong.world.judging import ENDINGS, LONGEST_SERVE, judge, landing_of
from rotorpong.world.racket import HOME_BODY
from rotorpong.world.render import render
from rotorpong.world.sensors import draw_sensors
from rotorpong.world.serves import Serve
from rotorpong.world.simulated_drone import Setting, Truth, blade_path, eye_of
from rotorpong.world.solids import TICK, Solids, parameters

STATE = (
    "ball_forward_m",  # of the ball from the centre of mass, level body axes, at the exposure
    "ball_left_m",
    "ball_up_m",
    "ball_forward_m_s",  # relative velocity of the ball, same axes and time
    "ball_left_m_s",
    "ball_up_m_s",
    "own_forward_m_s",  # of the centre of mass, level body axes; this and what follows: now
    "own_left_m_s",
    "own_up_m_s",
    "own_height_m",  # of the centre of mass above the table's surface
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
    "roll_rate_rad_s",  # body rates, body axes
    "pitch_rate_rad_s",
    "yaw_rate_rad_s",
    "time_s",  # since the release
    "sight_age_s",  # since the exposure: the camera's delay
)
SIDE_BY_SIDE = 128  # rows: what they fly in a leg stays in the processor's cache
Rows = Int64[ndarray, "rows"]


@dataclass(frozen=True, slots=True)
class Cast:
    """What one row plays: a serve, and the generators that `SimulatedDrone` takes."""

    serve: Serve
    vehicle_rng: np.random.Generator
    sensor_rng: np.random.Generator


class ServeBatch:
    """n drones, each with one serve on its way."""

    def __init__(self, setting: Setting, casts: Sequence[Cast]) -> None:
        """Let every row hover at home at the instant of its release.

        Args:
            setting: what all serves meet; a blackout does not matter here.
            casts: one for each row, at least one.

        Raises:
            InputError: no cast.
        """
        if not casts:
            raise InputError("a batch of 0 serves: expected at least 1")
        n = len(casts)
        self.setting, self._racket = setting, setting.racket
        self._limits = setting.vehicle.limits
        self._solids = Solids(racket=setting.racket)
        self._sizes = sizes_of(setting.racket)
        self._serves = [cast.serve for cast in casts]
        self._parameters = np.empty((n, len(parameters(self._solids))))
        self._logs = (
            np.empty((n, LONGEST_SERVE + 1, 9)),
            np.empty((n, LONGEST_SERVE + 1, 7)),
            np.empty((n, rules.WATCH_COLUMNS)),
        )
        self._clocks, self._rows = np.zeros((2, n), np.int64), np.empty(n, np.int64)
        self._codes, self._deciding = np.zeros(n, np.int64), np.empty((n, CONTACT_COLUMNS))
        self._contacts: list[list[Float[ndarray, "_"]]] = [[] for _ in casts]
        self._schedules = np.zeros((2, n, most_frames(setting.camera)), np.int64)
        self._frames = np.zeros(n, np.int64)
        self._legs = Legs(
            commands=np.zeros((n, 4)),
            are_new=np.ones(n, bool),
            starts=self._clocks[kernels.FLOWN],
            ticks=np.zeros(n, np.int64),
        )
        self._fly = rows_flown_by(setting.vehicle)
        self._touched = np.empty((n, MOST_CONTACTS, CONTACT_COLUMNS))
        self._touches = np.zeros(n, np.int64)
        self._judged = np.empty((2, n))
        self._states: VehicleState = _stacked([self._cast(i, c) for i, c in enumerate(casts)])

    @property
    def over(self) -> Bool[ndarray, "n"]:
        """Which serves are over."""
        return self._codes != rules.PLAYING

    def restart(self, rows: Sequence[int], casts: Sequence[Cast]) -> None:
        """Begin new serves in some rows."""
        for row, cast in zip(rows, casts, strict=True):
            _put(self._states, row, self._cast(row, cast))

    def command(
        self, velocities: Float[ndarray, "n 4"], told: Bool[ndarray, "n"] | None = None
    ) -> Float[ndarray, "n 4"]:
        """Fly at these velocities (forward, left, up, yaw rate) from now on; return them clipped.

        Args:
            velocities: m/s and rad/s, one row for each serve.
            told: which rows get their command; the others go on as before. All by default.

        Raises:
            InputError: a component is not finite, or there is not one command for each row.
        """
        commands = self._legs.commands
        if velocities.shape != commands.shape or not np.isfinite(velocities).all():
            raise InputError(
                f"commands {np.array2string(velocities, threshold=8)}: expected finite velocities "
                f"in m/s and rad/s, shape {commands.shape}"
            )
        within = np.minimum(np.maximum(velocities, -self._limits), self._limits)
        rows = slice(None) if told is None else told
        commands[rows], self._legs.are_new[rows] = within[rows], True
        return within

    def advance(self) -> None:
        """Let every row that is not over run until its next frame arrives, or its serve is over.

        Raises:
            InputError: a vehicle flew to where no number is.
        """
        count = kernels.depart(
            self._codes, self._schedules, self._frames, self._clocks, self._legs.ticks, self._rows
        )
        for first in range(0, count, SIDE_BY_SIDE):
            self._leg(self._rows[first : min(first + SIDE_BY_SIDE, count)])

    def states(self) -> Float[ndarray, "n 18"]:
        """Return what `STATE` names of every row, at its last frame or at the end of its serve."""
        seen = np.empty((len(self._codes), len(STATE)))
        kernels.see(self._states.motion, *self._logs[:2], self._clocks, TICK, seen)
        return seen

    @property
    def outcomes(self) -> list[Outcome | None]:
        """What became of each serve; None where it is not over."""
        return [ENDINGS[code] for code in self._codes.tolist()]

    @property
    def miss_distances(self) -> Float[ndarray, "n"]:
        """How near the blade came to each ball, m: 0 for a hit; nan where it is not over."""
        return self._judged[0]

    @property
    def time_errors(self) -> Float[ndarray, "n"]:
        """How late the blades were, s; nan where that cannot be told or the serve is not over."""
        lags = self._judged[1]
        return np.where(np.abs(lags) <= rules.LONGEST_LAG, lags * TICK, np.nan)

    def picture(self, row: int) -> Picture:
        """Return the last frame of a row, sharp: without the camera's blur and noise."""
        balls, poses, _ = self._logs
        exposed = min(self._clocks[kernels.EXPOSED, row], self._clocks[kernels.FLOWN, row])
        camera = self.setting.camera
        eye, axes = eye_of(camera, poses[row, exposed])
        return render(camera, eye, axes, balls[row, exposed, :3].copy(), self.setting.scene)

    def truth(self, row: int) -> Truth:
        """Return what really happened in a serve.

        Raises:
            InputError: it is not over.
        """
        outcome = ENDINGS[self._codes[row]]
        if outcome is None:
            raise InputError(f"the serve of row {row} is not over")
        decided = outcome in {"hit", "hull"}
        contact = contact_from_row(self._deciding[row]) if decided else None
        end = self._clocks[kernels.FLOWN, row] + 1
        balls, track = self._logs[0][row, :end], self._logs[1][row, :end]
        verdict, miss, late = judge(outcome, contact, balls, track, self._racket)
        return Truth(
            verdict=verdict,
            miss_distance=miss,
            time_error=late,
            landing_x=landing_of(outcome, contact, balls, self._solids_of(self._serves[row])),
            ball_path=balls[:, :3].copy(),
            body_path=track[:, :3].copy(),
            blade_path=blade_path(track, self._racket),
            attitude_path=track[:, 3:].copy(),
            contacts=tuple(map(contact_from_row, self._contacts[row])),
        )

    def _cast(self, row: int, cast: Cast) -> VehicleState:
        """Write down a new serve; return how its vehicle starts."""
        vehicle, camera = self.setting.vehicle, self.setting.camera
        state = vehicle.start(np.array(HOME_BODY), cast.vehicle_rng)
        draw_sensors(vehicle.sensor_noise, cast.sensor_rng)  # as SimulatedDrone: the phase is next
        camera_rng = None
        if not is_regular(camera):
            camera_rng = cast.sensor_rng.spawn(1)[0]
            camera_rng.integers(2**62)  # the key of the pictures' noise
        for kind, ticks in enumerate(schedule(camera, cast.sensor_rng, camera_rng)):
            self._schedules[kind, row, : len(ticks)] = ticks
        self._frames[row], self._codes[row] = 0, rules.PLAYING
        self._legs.commands[row], self._legs.are_new[row] = 0.0, True
        self._judged[:, row] = np.nan
        self._contacts[row] = []
        self._serves[row] = cast.serve
        self._parameters[row] = parameters(self._solids_of(cast.serve))
        self._logs[0][row, 0] = state_of(cast.serve.ball)
        self._clocks[:, row] = 0
        return state

    def _leg(self, rows: Rows) -> None:
        """Let drones and balls of these rows fly to the arrival of their frames."""
        self._fly(self._states, rows, self._legs, self._logs[1])
        contacts, counts = self._touched, self._touches
        lost = kernels.fly_leg(
            rows,
            self._legs.ticks,
            self._parameters,
            *self._logs,
            self._clocks,
            self._codes,
            self._deciding,
            contacts,
            counts,
        )
        if lost >= 0:
            raise InputError(f"row {lost}: {TRACK_LOST}")
        self._legs.are_new[rows] = False
        for m in np.flatnonzero(counts[: len(rows)]):
            self._contacts[rows[m]].extend(contacts[m, : counts[m]].copy())
        ended = rows[self._codes[rows] != rules.PLAYING]
        if len(ended):
            kernels.judge_rows(
                ended, *self._logs, self._clocks, self._codes, self._sizes, self._judged
            )

    def _solids_of(self, serve: Serve) -> Solids:
        return self._solids._replace(air=serve.air, table=serve.table)


def _stacked(states: Sequence[VehicleState]) -> VehicleState:
    """Return one state with a leading axis, from states of single vehicles."""
    return VehicleState(
        *(np.stack([getattr(state, f.name) for state in states]) for f in fields(VehicleState))
    )


def _put(states: VehicleState, row: int, state: VehicleState) -> None:
    """Overwrite the state of a row in place."""
    for part, new in zip(parts_of(states), parts_of(state), strict=True):
        part[row] = new

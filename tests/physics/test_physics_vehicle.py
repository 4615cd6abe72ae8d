from dataclasses import fields, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vehicle_flights import FORWARD, HOME, LEFT, UP, YAW, body_axes, command, flight, joined, rng

from rotorpong.conventions import InputError
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.vehicle import (
    NOISE_FREE_CASCADE,
    TICK,
    TUM_GAZEBO,
    TUM_RANGES,
    Cascade,
    Legs,
    TumGazebo,
    Vehicle,
    VehicleState,
    rows_flown_by,
)

CALM = TumGazebo(NOISE_FREE_CASCADE)


def at_rest(drone=CALM, seed=0):
    return drone.start(HOME, rng(seed))


def step(axis, size, ticks=1000):
    return CALM.advance(at_rest(), command(axis, size), ticks=ticks, new_command=True)[1]


# The replica measured in the design's facts (drone, 1b), which rests on the plugin's source.
MEASURED_STEPS = [
    # m/s, t10, t63, t90 (s), tilt (deg), peak a, dx at 0.3, 0.5, 0.8, 1.0 s (m)
    (0.5, (0.097, 0.37, 0.69), 6.3, 1.08, (0.033, 0.100, 0.231, 0.325)),
    (1.0, (0.098, 0.37, 0.70), 12.4, 2.16, (0.065, 0.198, 0.460, 0.648)),
    (2.0, (0.133, 0.42, 0.755), 22.9, 4.14, (0.093, 0.329, 0.836, 1.208)),
]


@pytest.mark.parametrize(("speed", "times", "tilt", "peak", "way"), MEASURED_STEPS)
def test_velocity_steps_are_those_measured(speed, times, tilt, peak, way):
    track = step(FORWARD, speed, 3000)
    velocity = track.velocity[:, 0]
    crossings = [np.argmax(velocity >= part * speed) * TICK for part in (0.1, 1 - np.exp(-1), 0.9)]
    tilts = np.degrees(np.arccos(body_axes(track.quaternion).as_matrix()[:, 2, 2]))
    assert crossings == pytest.approx(times, rel=0.05)
    assert tilts.max() == pytest.approx(tilt, rel=0.05)
    assert track.acceleration[:, 0].max() == pytest.approx(peak, rel=0.05)
    gone = track.position[[300, 500, 800, 1000], 0] - track.position[0, 0]
    assert gone == pytest.approx(way, rel=0.05)
    assert velocity.max() < speed  # no overshoot


def test_the_vertical_step_is_slow_and_ripples_as_measured():
    climb = step(UP, 0.5, 2000).velocity[:, 2]
    assert climb[[500, 1000]] == pytest.approx([0.33, 0.45], rel=0.05)
    assert climb[1000:].std() == pytest.approx(0.03, abs=0.01)


def strike(time, way, duration):
    pull = 2 * way / duration**2
    return pull * time, pull


def minimum_jerk(time, way, duration):
    x = time / duration
    speed = way / duration * 30 * (x**2 - 2 * x**3 + x**4)
    return speed, way / duration**2 * 60 * (x - 3 * x**2 + 2 * x**3)


MEASURED_MISSES = [
    # motion, m, s, commands per second, cm short at the end for gains 0, 0.2, 0.3, 0.4 s
    (strike, 0.3, 0.6, 30, (-20.6, -11.3, -6.7, -2.1)),
    (strike, 0.3, 0.6, 50, (-19.3, -10.1, -5.6, -1.1)),
    (strike, 0.3, 0.6, 1000, (-11.6, -2.1, 2.6, 7.3)),
    (strike, 0.5, 0.8, 30, (-29.2, -14.9, -7.8, -0.7)),
    (minimum_jerk, 0.5, 0.8, 30, (-19.5, -7.0, -1.2, 1.5)),
]


@pytest.mark.parametrize(("motion", "way", "duration", "rate", "misses"), MEASURED_MISSES)
def test_feed_forward_misses_depend_on_the_command_rate_as_measured(
    motion, way, duration, rate, misses
):
    starts = [round(i * 1000 / rate) for i in range(int(np.ceil(duration * rate - 1e-9)))]
    for gain, miss in zip((0.0, 0.2, 0.3, 0.4), misses, strict=True):
        state = at_rest()
        for start, end in zip(starts, [*starts[1:], round(duration * 1000)], strict=True):
            speed, pull = motion(start * TICK, way, duration)
            order = command(FORWARD, speed + gain * pull)
            state, _ = CALM.advance(state, order, ticks=end - start, new_command=True)
        short = 100 * (state.position[0] - at_rest().position[0] - way)
        assert short == pytest.approx(miss, rel=0.05, abs=0.3)


def test_a_smooth_small_command_meets_the_linear_equations_of_the_cascade():
    """v' = g a, a'' = 10 (c - a) + 5 (c' - a'), g c = 5 (u - v) + u' - v', u a sine."""
    gravity, size, pace = 9.8, 0.05, 4.0

    def linear(time, y):
        velocity, tilt, rate = y
        u, du, ddu = (size * pace**n * np.sin(pace * time + n * np.pi / 2) for n in range(3))
        wanted = (5 * (u - velocity) + du) / gravity - tilt
        wanted_rate = (5 * du + ddu) / gravity - 5 * tilt - rate
        return gravity * tilt, rate, 10 * (wanted - tilt) + 5 * (wanted_rate - rate)

    # the wanted tilt starts from rest with c = u'(0) / g: a kick of 5 c to the rate
    kick = 5 * size * pace / gravity
    exact = solve_ivp(linear, (0, 1), (0, 0, kick), rtol=1e-9, atol=1e-12).y[0, -1]
    drone = TumGazebo(NOISE_FREE_CASCADE._replace(sample_ticks=1.0))
    state = at_rest(drone)
    for i in range(1000):
        order = command(FORWARD, size * np.sin(pace * i * TICK))
        state, _ = drone.advance(state, order, ticks=1, new_command=True)
    assert state.velocity[0] == pytest.approx(exact, rel=0.01)


def tumbling(**changes):
    """Return a drone whose loops are dead, spinning about no principal axis."""
    dead = dict.fromkeys(["vertical_p", "vertical_d", "tilt_p", "tilt_d", "yaw_p", "yaw_d"], 0.0)
    constants = Cascade(**(NOISE_FREE_CASCADE._asdict() | dead | changes))
    drone = TumGazebo(constants)
    motion = at_rest(drone).motion.copy()
    motion[10:13] = [4.0, -7.0, 5.0]
    return drone, replace(at_rest(drone), motion=motion)


def test_a_free_tumble_keeps_angular_momentum_and_energy():
    drone, state = tumbling(thrust_limit=0.0, inertia_y=0.02)
    _, track = drone.advance(state, command(), ticks=2000, new_command=True)
    inertia = np.array([drone.constants.inertia_x, 0.02, drone.constants.inertia_z])
    momentum = body_axes(track.quaternion).apply(inertia * track.body_rates)
    assert np.ptp(momentum, axis=0).max() < 1e-9 * np.linalg.norm(momentum[0])
    spin_energy = 0.5 * (inertia * track.body_rates**2).sum(axis=1)
    assert np.ptp(spin_energy) < 1e-9 * spin_energy[0]
    energy = 0.5 * (track.velocity**2).sum(axis=1) + 9.8 * track.position[:, 2]
    assert np.ptp(energy) < 1e-9


def test_a_free_tumble_is_that_of_eulers_equations():
    drone, state = tumbling(thrust_limit=0.0, inertia_y=0.02)
    inertia = np.array([drone.constants.inertia_x, 0.02, drone.constants.inertia_z])

    def motion(_, y):
        spin, turn = y[:3], y[3:].reshape(3, 3)
        hat = np.cross(spin, np.eye(3)).T  # hat @ u = spin x u
        return np.concatenate([-np.cross(spin, inertia * spin) / inertia, (turn @ hat).ravel()])

    start = np.concatenate([state.body_rates, np.eye(3).ravel()])
    exact = solve_ivp(motion, (0, 1), start, rtol=1e-11, atol=1e-12, method="DOP853").y[:, -1]
    after, _ = drone.advance(state, command(), ticks=1000, new_command=True)
    assert after.body_rates == pytest.approx(exact[:3], abs=1e-7)
    assert body_axes(after.quaternion).as_matrix().ravel() == pytest.approx(exact[3:], abs=1e-7)


def test_thrust_pulls_along_the_body_axis_and_its_work_is_the_gain_in_energy():
    track = step(FORWARD, 2.0)
    pull = track.acceleration[1:] + np.array([0.0, 0.0, 9.8])
    middle = body_axes(track.quaternion[:-1] + track.quaternion[1:]).as_matrix()[:, :, 2]
    along = (pull * middle).sum(axis=1)
    assert np.abs(pull - along[:, None] * middle).max() < 1e-3 * 9.8
    speed = 0.5 * (track.velocity[1:] + track.velocity[:-1])
    work = (along * (middle * speed).sum(axis=1)).sum() * TICK
    energy = 0.5 * (track.velocity**2).sum(axis=1) + 9.8 * track.position[:, 2]
    assert work == pytest.approx(energy[-1] - energy[0], rel=1e-3)


def test_a_calm_drone_told_to_hover_stays():
    _, track = CALM.advance(at_rest(), command(), ticks=1000, new_command=True)
    assert np.array_equal(track.position, np.broadcast_to(at_rest().position, (1001, 3)))


def test_noise_shakes_a_hovering_drone_without_carrying_it_off():
    start = TUM_GAZEBO.start(np.zeros((40, 3)), rng(1))
    orders = [np.zeros((40, 4))] * 30
    state, _ = flight(TUM_GAZEBO, start, [[33]] * 30, orders)
    assert 0.002 < state.position[:, :2].std() < 0.2
    mean = state.position.mean(axis=0)
    assert np.all(np.abs(mean) < 4 * state.position.std(axis=0) / np.sqrt(40))  # 4 sigma


def test_left_mirrors_right():
    left, right = step(LEFT, 0.8), step(LEFT, -0.8)
    flip = np.array([1.0, -1.0, 1.0])
    assert left.position == pytest.approx(right.position * flip, abs=1e-12)
    assert left.velocity == pytest.approx(right.velocity * flip, abs=1e-12)


def test_forward_and_left_are_alike():
    forward, left = step(FORWARD, 0.8), step(LEFT, 0.8)
    assert forward.velocity[:, 0] == pytest.approx(left.velocity[:, 1], rel=1e-6, abs=1e-9)


def test_a_command_acts_along_the_heading():
    state, _ = CALM.advance(at_rest(), command(YAW, 1.0), ticks=1000, new_command=True)
    state, _ = CALM.advance(state, command(), ticks=3000, new_command=True)
    heading = body_axes(state.quaternion).as_euler("ZYX")[0]
    assert heading == pytest.approx(1.0, abs=0.01)
    _, track = CALM.advance(state, command(FORWARD, 1.0), ticks=1500, new_command=True)
    direction = np.arctan2(track.velocity[-1, 1], track.velocity[-1, 0])
    assert direction == pytest.approx(heading, abs=1e-3)


def test_commands_beyond_the_limits_act_like_the_limits():
    beyond, _ = CALM.advance(at_rest(), np.full(4, 9.0), ticks=300, new_command=True)
    within, _ = CALM.advance(at_rest(), CALM.limits, ticks=300, new_command=True)
    assert np.array_equal(beyond.motion, within.motion)


def test_without_a_message_the_last_command_stays_in_force():
    state, _ = CALM.advance(at_rest(), command(FORWARD, 1.0), ticks=100, new_command=True)
    silent, _ = CALM.advance(state, command(), ticks=400, new_command=False)
    told, _ = CALM.advance(at_rest(), command(FORWARD, 1.0), ticks=500, new_command=True)
    assert np.array_equal(silent.motion, told.motion)


def test_each_message_has_its_own_noise_around_an_offset_that_lasts_five_seconds():
    state = TUM_GAZEBO.start(np.zeros((200, 3)), rng(8))
    heard = []
    for _ in range(200):
        state, _ = TUM_GAZEBO.advance(state, np.zeros((200, 4)), ticks=50, new_command=True)
        heard.append(state.held_command)
    early, late = np.array(heard[:100]), np.array(heard[100:])
    assert np.abs(heard).max() <= 0.08
    within = 0.05 / np.sqrt(3)
    assert (early - early.mean(axis=0)).std() == pytest.approx(within, rel=0.02)
    offsets = early.mean(axis=0)
    assert offsets.std() == pytest.approx(np.hypot(0.03, 0.05 / 10) / np.sqrt(3), rel=0.1)
    correlation = np.corrcoef(offsets.ravel(), late.mean(axis=0).ravel())[0, 1]
    assert abs(correlation) < 4 / np.sqrt(offsets.size)  # 4 sigma


def test_the_same_seed_flies_the_same_and_another_seed_differently():
    first, again, other = (
        TUM_GAZEBO.advance(at_rest(TUM_GAZEBO, s), command(), ticks=300, new_command=True)[0].motion
        for s in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("bad", [np.array([np.nan, 0, 0, 0]), np.array([0, np.inf, 0, 0])])
def test_a_command_that_is_not_finite_is_refused(bad):
    with pytest.raises(InputError, match="finite forward, left, up"):
        CALM.advance(at_rest(), bad, ticks=33, new_command=True)


def test_a_command_of_another_batch_is_refused():
    with pytest.raises(InputError, match="shape"):
        CALM.advance(at_rest(), np.zeros((2, 4)), ticks=33, new_command=True)


def test_tum_gazebo_is_a_vehicle():
    assert isinstance(TUM_GAZEBO, Vehicle)
    assert TUM_GAZEBO.limits.tolist() == [2.0, 2.0, 0.5, 1.5]


@pytest.mark.parametrize(
    "change",
    [
        {"mass": 0.0},
        {"inertia_x": -1.0},
        {"gravity": np.nan},
        {"sample_ticks": 0.0},
        {"sample_ticks": 2.5},
        {"tilt_limit": 2.0},
        {"command_offset_period": 0.0},
        {"horizontal_p": np.inf},
    ],
)
def test_impossible_constants_are_refused(change):
    with pytest.raises(InputError, match=r"tum_gazebo: .*expected a finite number"):
        TumGazebo(Cascade(**change))


def test_every_range_holds_the_nominal_value_and_drones_are_drawn_from_it():
    drones = [TUM_GAZEBO.randomized(rng(seed)) for seed in range(200)]
    for name, (low, high) in TUM_RANGES.items():
        values = np.array([getattr(drone.constants, name) for drone in drones])
        assert low <= getattr(TUM_GAZEBO.constants, name) <= high
        assert low <= values.min() < values.max() <= high
    others = set(Cascade._fields) - set(TUM_RANGES)
    assert all(getattr(d.constants, n) == getattr(Cascade(), n) for d in drones for n in others)
    whites = np.array([drone.sensor_noise.velocity_white for drone in drones])
    assert 0.05 <= whites.min() < whites.max() <= 0.15
    for drone in drones:
        assert drone.sensor_noise.gyro_white == 0.0
        assert drone.sensor_noise.attitude_white == drone.constants.attitude_noise  # one imu


def test_every_drawn_drone_flies():
    for seed in range(20):
        drone = TUM_GAZEBO.randomized(rng(seed))
        state, _ = drone.advance(
            at_rest(drone, seed), command(FORWARD, 1.0), ticks=2500, new_command=True
        )
        assert state.velocity[0] == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize("sample_ticks", [1.0, 2.0, 3.0, 10.0])
def test_a_flight_in_single_ticks_is_the_flight_in_one(sample_ticks):
    """Within a leg the cascade is not asked again while nothing changes: it must not matter."""
    drone = TumGazebo(TUM_GAZEBO.constants._replace(sample_ticks=sample_ticks))
    orders = rng(2).uniform(-2, 2, (6, 4))
    whole, path = flight(drone, at_rest(drone), [[33]] * 6, orders)
    single, steps = flight(drone, at_rest(drone), [[1] * 33] * 6, orders)
    assert np.array_equal(joined(path, "position"), joined(steps, "position"))
    assert np.array_equal(whole.memory, single.memory)


@pytest.mark.parametrize("drone", [TUM_GAZEBO, ARDRONE2, ARDRONE2_RAW], ids=lambda d: d.name)
def test_rows_that_fly_legs_of_their_own_fly_as_each_would_alone(drone):
    n, draw = 19, rng(7)
    together, start = (drone.start(np.tile([0.0, 0.5, 1.0], (n, 1)), rng(3)) for _ in range(2))
    alone = [
        VehicleState(*(np.asarray(getattr(start, f.name)[i]) for f in fields(start)))
        for i in range(n)
    ]
    poses, starts = np.full((n, 400, 7), np.nan), np.zeros(n, np.int64)
    for _ in range(8):
        flying = draw.permutation(n)[: draw.integers(1, n + 1)]
        ticks = draw.integers(0, 45, n)
        legs = Legs(draw.uniform(-1, 1, (n, 4)), draw.random(n) < 0.5, starts, ticks)
        rows = flying[np.argsort(-ticks[flying])]
        rows_flown_by(drone)(together, rows, legs, poses)
        for row in rows:
            alone[row], track = drone.advance(
                alone[row],
                legs.commands[row],
                ticks=int(ticks[row]),
                new_command=bool(legs.are_new[row]),
            )
            expected = np.column_stack([track.position, track.quaternion])
            assert np.array_equal(poses[row, starts[row] :][: ticks[row] + 1], expected)
        starts[rows] += ticks[rows]
    for name in ("motion", "memory", "counters"):
        assert np.array_equal(getattr(together, name), [getattr(one, name) for one in alone])

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from vehicle_flights import FORWARD, HOME, LEFT, UP, YAW, body_axes, command, flight, rng

from rotorpong.conventions import InputError
from rotorpong.physics.ardrone2 import (
    ARDRONE2,
    ARDRONE2_NOISE,
    ARDRONE2_RANGES,
    ARDRONE2_RAW,
    FACTORY_SETTINGS,
    NOMINAL_AIRFRAME,
    Airframe,
    ArDrone2,
    Settings,
    VelocityLoop,
)
from rotorpong.physics.vehicle import SCALED_NOISE, TICK, Vehicle

QUIET = replace(ARDRONE2_NOISE, velocity_white=0.0, velocity_bias=0.0)
CALM = ArDrone2(noise=QUIET)
RAW = replace(ARDRONE2_RAW, noise=QUIET)


def at_rest(drone=CALM, seed=0):
    return drone.start(HOME, rng(seed))


def step(drone, axis, size, ticks=1000):
    return drone.advance(at_rest(drone), command(axis, size), ticks=ticks, new_command=True)[1]


def tilted(degrees, dead_time, **constants):
    """Return a raw drone with another tilt limit and dead time, its battery always full."""
    airframe = NOMINAL_AIRFRAME._replace(dead_time=dead_time, battery_sag=0.0, **constants)
    settings = FACTORY_SETTINGS._replace(tilt_limit=float(np.radians(degrees)))
    return replace(RAW, constants=airframe, settings=settings)


# The reach measured in the design's facts (drone, 1a), in metres at 0.4, 0.5, 0.6, 0.7, 0.8, 1.0 s.
MEASURED_REACH = [
    (12, 0.1, (0.041, 0.085, 0.145, 0.222, 0.314, 0.544)),
    (12, 0.2, (0.014, 0.041, 0.085, 0.145, 0.222, 0.422)),
    (20, 0.1, (0.069, 0.140, 0.240, 0.367, 0.519, 0.898)),
    (30, 0.1, (0.102, 0.208, 0.355, 0.541, 0.766, 1.322)),
    (30, 0.2, (0.036, 0.102, 0.208, 0.355, 0.541, 1.026)),
]
INSTANTS = [400, 500, 600, 700, 800, 1000]


@pytest.mark.parametrize(("degrees", "dead_time", "reach"), MEASURED_REACH)
def test_the_reach_by_tilt_and_dead_time_is_that_measured(degrees, dead_time, reach):
    way = step(tilted(degrees, dead_time), FORWARD, 1.0).position[INSTANTS, 0] - HOME[0]
    rounded = 0.0005  # m: the table has whole millimetres
    assert np.all(np.abs(way - reach) <= 0.02 * np.array(reach) + rounded)


@pytest.mark.parametrize(("degrees", "dead_time"), [(12, 0.1), (30, 0.2), (29.8, 0.073)])
def test_the_reach_is_the_closed_form_of_two_lags(degrees, dead_time):
    drone = tilted(degrees, dead_time)
    c, goal = drone.constants, np.radians(degrees)
    slow, quick = 1 / c.drag, c.tilt_lag
    since = np.arange(1001) * TICK - np.ceil(dead_time / TICK) * TICK
    t = np.maximum(since, 0.0)
    bend = slow**2 * (1 - np.exp(-t / slow)) - quick**2 * (1 - np.exp(-t / quick))
    exact = c.pull / c.drag * np.sin(goal) * (t - bend / (slow - quick))
    way = step(drone, LEFT, 1.0).position[:, 1]
    # the closed form lets sin(tilt) lag, the drone lets the tilt lag
    assert np.all((way >= exact - 1e-6) & (way <= exact * goal / np.sin(goal) + 1e-6))
    assert degrees > 12 or way == pytest.approx(exact, rel=0.02, abs=1e-6)


def test_the_climb_is_the_closed_form_of_one_lag():
    height = step(CALM, UP, 2.0).position[:, 2] - HOME[2]
    t = np.maximum(np.arange(1001) * TICK - 0.1, 0.0)
    assert height == pytest.approx(2.0 * (t - (1 - np.exp(-0.8 * t)) / 0.8), rel=0.002)
    assert height[[400, 600, 800]] == pytest.approx([0.067, 0.176, 0.33], rel=0.02)  # feasibility


@pytest.mark.parametrize(
    ("drone", "order"),
    [
        (tilted(12, 0.1), [1.0, 0.0, 0.0, 0.0]),
        (tilted(29, 0.06, drag=0.3), [-1.0, 0.7, 0.5, 0.3]),
        (tilted(25, 0.12, turn_rate=10.0, pull=9.2), [0.4, -1.0, -1.0, -1.0]),
    ],
)
def test_a_flight_is_what_scipy_integrates(drone, order):
    c, limits = drone.constants, drone.settings
    forward, left, up, turn = order
    goal_roll, goal_pitch = -left * limits.tilt_limit, forward * limits.tilt_limit

    def motion(_, y):
        _, _, _, *v, roll, pitch, yaw, yaw_rate = y
        push = c.pull * Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()[:2, 2]
        climb = c.climb_rate * (up * limits.climb_limit - v[2])
        turning = c.turn_rate * (turn * limits.turn_limit - yaw_rate)
        tilting = [(goal_roll - roll) / c.tilt_lag, (goal_pitch - pitch) / c.tilt_lag]
        return [*v, *(push - c.drag * np.array(v[:2])), climb, *tilting, yaw_rate, turning]

    span = 1.5 - c.dead_time
    start = [*HOME, *np.zeros(7)]
    exact = solve_ivp(motion, (0, span), start, rtol=1e-10, atol=1e-12, method="DOP853").y[:, -1]
    after, _ = drone.advance(at_rest(drone), np.array(order), ticks=1500, new_command=True)
    assert after.position == pytest.approx(exact[0:3], abs=5e-6)
    assert after.velocity == pytest.approx(exact[3:6], abs=5e-6)
    yaw_pitch_roll = body_axes(after.quaternion).as_euler("ZYX")
    assert yaw_pitch_roll == pytest.approx(exact[[8, 7, 6]], abs=1e-9)


def test_body_rates_are_the_turning_of_the_attitude():
    drone = tilted(25, 0.1)
    order = np.array([1.0, -0.7, 0.5, 1.0])
    _, track = drone.advance(at_rest(drone), order, ticks=1200, new_command=True)
    turns = body_axes(track.quaternion[101:])
    turning = (turns[:-2].inv() * turns[2:]).as_rotvec() / (2 * TICK)
    assert turning == pytest.approx(track.body_rates[102:-1], abs=1e-3)
    assert np.abs(turning).max(axis=0).min() > 1.0


def test_the_work_of_thrust_drag_and_gravity_is_the_gain_in_energy():
    order = np.array([3.0, 2.0, 1.0, 1.0])
    _, track = CALM.advance(at_rest(), order, ticks=1500, new_command=True)
    c = CALM.constants
    force = track.acceleration[1:] + np.array([0.0, 0.0, 9.81])  # per kg, all but gravity
    speed = 0.5 * (track.velocity[1:] + track.velocity[:-1])
    push = c.pull * body_axes(track.quaternion).as_matrix()[:, :2, 2]
    sag = 1 - c.battery_sag * (np.arange(1500) + 0.5) * TICK / c.battery_life
    model = sag[:, None] * 0.5 * (push[1:] + push[:-1]) - c.drag * speed[:, :2]
    assert force[:, :2] == pytest.approx(model, abs=1e-4)
    power = (model * speed[:, :2]).sum(axis=1) + force[:, 2] * speed[:, 2]
    energy = 0.5 * (track.velocity**2).sum(axis=1) + 9.81 * track.position[:, 2]
    assert power.sum() * TICK == pytest.approx(energy[-1] - energy[0], rel=1e-5)
    assert energy[-1] - energy[0] > 3.0


def test_a_coasting_drone_loses_speed_to_drag_alone():
    fast, _ = RAW.advance(at_rest(RAW), command(FORWARD, 1.0), ticks=2000, new_command=True)
    _, track = RAW.advance(fast, command(), ticks=4000, new_command=True)
    late = track.velocity[3000:, 0]  # level by then
    assert late == pytest.approx(late[0] * np.exp(-0.58 * TICK * np.arange(1001)), rel=1e-6)


@pytest.mark.parametrize(("axis", "size"), [(FORWARD, 1.0), (LEFT, -2.0), (UP, 0.5), (YAW, 1.0)])
def test_the_loop_brings_the_drone_to_the_velocity_commanded(axis, size):
    track = step(CALM, axis, size, 4000)
    flown = (
        track.velocity[:, axis] if axis < YAW else np.gradient(heading(track.quaternion), TICK)
    ) / size
    assert flown[-1] == pytest.approx(1.0, abs=0.005)
    assert flown.max() < 1.02
    assert np.all(np.abs(flown[:100]) < 1e-9)  # dead time


def heading(quaternion):
    return np.unwrap(body_axes(quaternion).as_euler("ZYX")[:, 0])


def test_small_steps_lag_by_dead_time_and_gain_as_the_loop_is_laid_out():
    velocity = step(CALM, FORWARD, 0.2, 2000).velocity[:, 0] / 0.2
    lag = (1.0 - velocity).sum() * TICK  # of a linear follower: its delay to a ramp
    assert lag == pytest.approx(0.1 + (1 + 0.14 * 0.58) / 2.5, abs=0.005)


def test_the_loop_uses_the_whole_tilt_limit_and_never_more():
    track = step(CALM, FORWARD, 5.0, 1000)
    pitch = body_axes(track.quaternion).as_euler("ZYX")[:, 1]
    assert 0.51 < pitch.max() <= 0.52


@pytest.mark.parametrize(
    "change",
    [{"drag": 0.3}, {"drag": 0.8}, {"pull": 9.135}, {"dead_time": 0.12}, {"tilt_lag": 0.18}],
)
def test_the_loop_steers_drones_that_it_does_not_know(change):
    drone = replace(CALM, constants=NOMINAL_AIRFRAME._replace(**change))
    velocity = step(drone, FORWARD, 1.0, 9000).velocity[:, 0]
    assert velocity[-1] == pytest.approx(1.0, abs=0.01)
    assert velocity.max() < 1.2
    assert np.ptp(velocity[-500:]) < 0.01  # it settles


def test_the_drone_comes_to_rest_and_does_not_drift_with_noise():
    start = ARDRONE2.start(np.zeros((100, 3)), rng(1))
    state, _ = ARDRONE2.advance(start, np.zeros((100, 4)), ticks=3000, new_command=True)
    assert 0.01 < state.velocity.std() < 0.05  # the bias of the flow: 0.03 m/s
    mean = state.position.mean(axis=0)
    assert np.all(np.abs(mean) < 4 * state.position.std(axis=0) / np.sqrt(100))  # 4 sigma


def test_raw_means_the_inclination_of_the_factory():
    track = step(ARDRONE2_RAW, FORWARD, 1.0, 9000)
    pitch = body_axes(track.quaternion[-1]).as_euler("ZYX")[1]
    assert np.degrees(pitch) == pytest.approx(12.0, abs=1e-6)
    assert track.velocity[-1, 0] == pytest.approx(3.64, rel=0.01)  # facts, 1a: v_ss
    climb = step(ARDRONE2_RAW, UP, 1.0, 9000).velocity[-1, 2]
    assert climb == pytest.approx(0.7, rel=0.01)
    assert ARDRONE2_RAW.limits.tolist() == [1.0] * 4
    beyond = step(ARDRONE2_RAW, FORWARD, 7.0).position
    assert np.array_equal(beyond, step(ARDRONE2_RAW, FORWARD, 1.0).position)


def test_a_flat_battery_pulls_less_and_navdata_know_the_charge():
    empty = replace(RAW, constants=NOMINAL_AIRFRAME._replace(battery_charge=0.0))
    full, flat = (step(drone, FORWARD, 1.0).velocity[-1, 0] for drone in (RAW, empty))
    assert flat / full == pytest.approx(0.9, abs=1e-3)
    assert empty.sensor_noise.battery_charge == 0.0
    assert empty.sensor_noise.battery_life == 660.0


def test_velocity_is_seen_forty_milliseconds_late():
    _, track = CALM.advance(at_rest(), np.array([3.0, 1.0, 1.0, 0.5]), ticks=900, new_command=True)
    assert np.array_equal(track.seen_velocity[45::5], track.velocity[5:-40:5])
    assert not track.seen_velocity[:41].any()


def test_a_command_acts_along_the_heading():
    state, _ = CALM.advance(at_rest(), command(YAW, 1.0), ticks=1000, new_command=True)
    state, _ = CALM.advance(state, command(), ticks=1000, new_command=True)
    _, track = CALM.advance(state, command(FORWARD, 1.0), ticks=1500, new_command=True)
    direction = np.arctan2(track.velocity[-1, 1], track.velocity[-1, 0])
    assert direction == pytest.approx(heading(track.quaternion)[-1], abs=1e-6)


def test_left_mirrors_right_and_forward_is_like_left():
    left, right = step(CALM, LEFT, 1.5), step(CALM, LEFT, -1.5)
    assert np.array_equal(left.position[:, 1], -right.position[:, 1])
    forward = step(CALM, FORWARD, 1.5)
    assert forward.velocity[:, 0] == pytest.approx(left.velocity[:, 1], abs=1e-12)


def test_a_calm_drone_told_to_hover_stays():
    track = step(CALM, FORWARD, 0.0)
    assert np.array_equal(track.position, np.broadcast_to(HOME, (1001, 3)))


def test_without_a_message_the_last_command_stays_in_force():
    state, _ = CALM.advance(at_rest(), command(FORWARD, 1.0), ticks=100, new_command=True)
    silent, _ = CALM.advance(state, command(), ticks=400, new_command=False)
    told, _ = CALM.advance(at_rest(), command(FORWARD, 1.0), ticks=500, new_command=True)
    assert np.array_equal(silent.motion, told.motion)
    assert silent.held_command.tolist() == [1.0, 0.0, 0.0, 0.0]


def test_the_same_seed_flies_the_same_and_another_seed_differently():
    first, again, other = (
        ARDRONE2.advance(at_rest(ARDRONE2, s), command(), ticks=300, new_command=True)[0].motion
        for s in (1, 1, 2)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_every_constant_has_a_range_with_the_nominal_value_in_it():
    assert set(ARDRONE2_RANGES) == set(Airframe._fields)
    for name, (low, high) in ARDRONE2_RANGES.items():
        assert low < high
        assert low <= getattr(NOMINAL_AIRFRAME, name) <= high


def test_drones_are_drawn_evenly_from_the_ranges_and_keep_their_loop():
    drones = [ARDRONE2.randomized(rng(seed)) for seed in range(400)]
    for name, (low, high) in ARDRONE2_RANGES.items():
        share = (np.array([getattr(d.constants, name) for d in drones]) - low) / (high - low)
        assert 0.0 <= share.min() < share.max() <= 1.0
        assert share.mean() == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / 400))  # 4 sigma
    for name in SCALED_NOISE:
        levels = np.array([getattr(d.noise, name) for d in drones])
        nominal = getattr(ARDRONE2_NOISE, name)
        assert np.all((levels >= 0.5 * nominal) & (levels <= 1.5 * nominal))
    assert {(d.loop, d.settings, d.name) for d in drones} == {
        (ARDRONE2.loop, ARDRONE2.settings, "ardrone2")
    }


def test_every_drawn_drone_flies_and_stays_finite():
    for seed in range(30):
        drone = ARDRONE2.randomized(rng(seed))
        orders = rng(seed).uniform(-1, 1, (60, 4)) * drone.limits
        state, _ = flight(drone, at_rest(drone), [[33]] * 60, orders)
        assert np.isfinite(state.memory).all()
        assert np.abs(state.velocity).max() < 9.0


@pytest.mark.parametrize("bad", [np.array([np.nan, 0, 0, 0]), np.array([0, 0, 0, -np.inf])])
@pytest.mark.parametrize("drone", [CALM, RAW])
def test_a_command_that_is_not_finite_is_refused(drone, bad):
    with pytest.raises(InputError, match="finite forward, left, up"):
        drone.advance(at_rest(drone), bad, ticks=33, new_command=True)


def test_a_command_of_another_batch_is_refused():
    with pytest.raises(InputError, match="shape"):
        CALM.advance(at_rest(), np.zeros((2, 4)), ticks=33, new_command=True)


@pytest.mark.parametrize(
    "part",
    [
        {"constants": NOMINAL_AIRFRAME._replace(tilt_lag=0.0)},
        {"constants": NOMINAL_AIRFRAME._replace(drag=-0.58)},
        {"constants": NOMINAL_AIRFRAME._replace(pull=float("nan"))},
        {"constants": NOMINAL_AIRFRAME._replace(dead_time=0.21)},
        {"constants": NOMINAL_AIRFRAME._replace(dead_time=-0.1)},
        {"constants": NOMINAL_AIRFRAME._replace(battery_charge=1.2)},
        {"constants": NOMINAL_AIRFRAME._replace(battery_life=0.0)},
        {"settings": Settings(tilt_limit=1.6)},
        {"settings": Settings(climb_limit=float("inf"))},
        {"loop": VelocityLoop(gain=-2.5)},
        {"loop": VelocityLoop(velocity_delay=0.2)},
    ],
)
def test_impossible_constants_are_refused(part):
    with pytest.raises(InputError, match=r"ardrone2: .*expected a finite number"):
        replace(ARDRONE2, **part)


def test_ardrone2_is_a_vehicle():
    assert isinstance(ARDRONE2, Vehicle)
    assert ARDRONE2.limits.tolist() == [5.0, 5.0, 2.0, 1.75]

import math
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError
from rotorpong.physics import _ball_kernels as kernels
from rotorpong.physics.ball import (
    TABLE_SURFACE,
    Air,
    Ball,
    Surface,
    acceleration,
    bounce,
    fly,
)

UP = np.array([0.0, 0.0, 1.0])
VACUUM = Air(0.0, 0.0, 0.0)
MASS = 0.0027  # kg
speeds = st.floats(-15.0, 15.0)
spins = st.floats(-300.0, 300.0)
surfaces = st.builds(Surface, st.floats(0.0, 1.0), st.floats(0.0, 2.0))
velocities = st.tuples(speeds, speeds, speeds).map(np.array)
rotations = st.tuples(spins, spins, spins).map(np.array)
cheaply = settings(max_examples=100, deadline=None, derandomize=True)


def ball(velocity, spin=(0.0, 0.0, 0.0), position=(0.0, 0.0, 0.0)):
    return Ball(*(np.array(part, dtype=float) for part in (position, velocity, spin)))


def random_balls(n, seed=0):
    rng = np.random.default_rng(seed)
    return Ball(*(scale * rng.standard_normal((n, 3)) for scale in (1.0, 5.0, 50.0)))


def kinetic(thrown):
    """Return translational and rotational energy over mass of a thin shell."""
    turning = BALL_RADIUS**2 / 3 * np.sum(thrown.spin**2, axis=-1)
    return 0.5 * np.sum(thrown.velocity**2, axis=-1) + turning


def mechanical(thrown):
    return kinetic(thrown) + GRAVITY * thrown.position[..., 2]


def slip(thrown, normal):
    tangential = thrown.velocity - thrown.velocity @ normal * normal
    return tangential + np.cross(thrown.spin, -BALL_RADIUS * normal)


def about_contact(thrown, normal):
    """Return the angular momentum over mass about the point of contact."""
    orbital = np.cross(BALL_RADIUS * normal, thrown.velocity)
    return orbital + 2 / 3 * BALL_RADIUS**2 * thrown.spin


def unit(vector):
    return vector / np.linalg.norm(vector)


def test_a_vacuum_flight_is_the_exact_parabola():
    thrown = ball((5.0, -1.0, 3.0), (10.0, 20.0, 30.0), (1.0, 2.0, 3.0))
    flown = fly(thrown, VACUUM, 1.2345)
    fall = np.array([0.0, 0.0, -GRAVITY])
    path = thrown.position + 1.2345 * thrown.velocity + 0.5 * 1.2345**2 * fall
    assert flown.position == pytest.approx(path, abs=1e-12)
    assert flown.velocity == pytest.approx(thrown.velocity + 1.2345 * fall, abs=1e-12)
    assert np.array_equal(flown.spin, thrown.spin)


def test_a_long_fall_ends_at_terminal_speed():
    air = Air()
    flown = fly(ball((0.0, 0.0, 0.0)), air, 20.0)
    assert flown.velocity[2] == pytest.approx(-math.sqrt(GRAVITY / air.drag), rel=1e-12)


def test_a_fall_with_drag_follows_the_hyperbolic_tangent():
    terminal = math.sqrt(GRAVITY / 0.15)
    flown = fly(ball((0.0, 0.0, 0.0)), Air(), 0.5)
    phase = GRAVITY * 0.5 / terminal
    assert flown.velocity[2] == pytest.approx(-terminal * math.tanh(phase), abs=1e-9)
    fallen = terminal**2 / GRAVITY * math.log(math.cosh(phase))
    assert flown.position[2] == pytest.approx(-fallen, abs=1e-9)


@given(
    velocities, rotations, st.floats(0.0, 1.0), st.floats(0.0, 0.3), st.floats(0.0, 0.004),
    st.floats(0.0, 20.0),
)  # fmt: skip
@cheaply
def test_drag_and_magnus_never_add_energy(velocity, spin, duration, drag, magnus, saturation):
    before = ball(velocity, spin)
    after = fly(before, Air(drag, magnus, saturation=saturation), duration)
    assert mechanical(after) <= mechanical(before) + 1e-7 * (1.0 + kinetic(before))


def lift_of(velocity, spin, air):
    return acceleration(ball(velocity, spin), air) - acceleration(ball(velocity), air)


@given(velocities, rotations)
@cheaply
def test_lift_is_linear_in_small_spins_and_saturates_for_large_ones(velocity, spin):
    if np.linalg.norm(velocity) < 1.0:
        return  # a slow ball's spin ratio is never small
    air = Air()
    linear = air.magnus * np.cross(spin, velocity)
    small = lift_of(velocity, 1e-6 * spin, air)
    assert small == pytest.approx(1e-6 * linear, rel=1e-4, abs=1e-12)
    assert lift_of(velocity, spin, air._replace(saturation=0.0)) == pytest.approx(linear, abs=1e-9)
    most = air.magnus * (velocity @ velocity) / (air.saturation * BALL_RADIUS)
    sizes = [np.linalg.norm(lift_of(velocity, n * spin, air)) for n in (1.0, 2.0, 4.0, 1e9)]
    assert np.all(np.diff(sizes) >= -1e-9)
    assert sizes[-1] <= most * (1.0 + 1e-9) + 1e-9


def test_the_lift_coefficient_is_that_of_the_spin_ratio():
    """C = S / (a + b S), whose two numbers are those of `Air` in other units."""
    air, area, density, speed = Air(), math.pi * BALL_RADIUS**2, 1.2, 7.0
    a = density * area * BALL_RADIUS / (2.0 * MASS * air.magnus)
    for ratio in (0.05, 0.2, 0.5, 1.0):
        spin = (0.0, 0.0, ratio * speed / BALL_RADIUS)
        lift = lift_of(np.array([speed, 0.0, 0.0]), spin, air)
        coefficient = lift[1] * MASS / (0.5 * density * area * speed**2)
        assert coefficient == pytest.approx(ratio / (a + air.saturation * a * ratio), rel=1e-9)
        assert lift[[0, 2]] == pytest.approx([0.0, 0.0], abs=1e-12)


@given(velocities, rotations)
@cheaply
def test_magnus_alone_keeps_the_kinetic_energy_it_turns(velocity, spin):
    push = acceleration(ball(velocity, spin), Air(0.0, 0.0016)) + GRAVITY * UP
    scale = 1.0 + np.linalg.norm(spin) * np.linalg.norm(velocity)
    assert abs(push @ velocity) < 1e-12 * scale * (1.0 + np.linalg.norm(velocity))


def test_topspin_dips_and_backspin_lifts():
    thrown, air = ball((-7.0, 0.0, 1.0)), Air()
    straight = fly(thrown, air, 0.5).position[2]
    rolling = np.cross(UP, unit(thrown.velocity))  # the way it would roll on a table
    assert fly(replace(thrown, spin=50.0 * rolling), air, 0.5).position[2] < straight - 0.03
    assert fly(replace(thrown, spin=-50.0 * rolling), air, 0.5).position[2] > straight + 0.03


@given(rotations, st.floats(0.0, 10.0), st.floats(0.0, 2.0))
@cheaply
def test_spin_decays_exponentially(spin, decay, duration):
    flown = fly(ball((3.0, 0.0, 1.0), spin), Air(spin_decay=decay), duration)
    assert flown.spin == pytest.approx(math.exp(-decay * duration) * spin, rel=1e-6)


def test_without_decay_spin_and_flight_are_those_of_a_constant_spin():
    balls, air = random_balls(10), Air(spin_decay=0.0)
    flown = fly(balls, air, 0.5)
    assert np.array_equal(flown.spin, balls.spin)
    position, velocity = balls.position.copy(), balls.velocity.copy()
    for _ in range(100):  # RK4 with the written acceleration
        h, slopes, stage = 0.005, [], velocity
        for share in (0.5, 0.5, 1.0, 0.0):
            slopes.append(acceleration(Ball(position, stage, balls.spin), air))
            stage = velocity + share * h * slopes[-1]
        a, b, c, d = slopes
        position = position + h * velocity + h * h / 6.0 * (a + b + c)
        velocity = velocity + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    assert flown.position == pytest.approx(position, abs=1e-12)
    assert flown.velocity == pytest.approx(velocity, abs=1e-12)


def test_an_ittf_drop_in_air_loses_to_drag_what_the_closed_form_says():
    fall, k, e = 0.305, Air().drag, TABLE_SURFACE.restitution
    terminal = GRAVITY / k
    strike = math.sqrt(terminal * -math.expm1(-2.0 * k * fall))
    rebound = math.log1p((e * strike) ** 2 / terminal) / (2.0 * k)  # rise against drag
    down = fly(
        ball((0.0, 0.0, 0.0)), Air(), math.acosh(math.exp(k * fall)) / math.sqrt(GRAVITY * k)
    )
    assert down.position[2] == pytest.approx(-fall, abs=1e-9)
    assert down.velocity[2] == pytest.approx(-strike, abs=1e-9)
    up = bounce(down, UP, TABLE_SURFACE)
    rise = math.atan(e * strike / math.sqrt(terminal)) / math.sqrt(GRAVITY * k)
    assert fly(up, Air(), rise).position[2] + fall == pytest.approx(rebound, abs=1e-9)
    assert rebound < e**2 * fall  # which is what it would be without air


@pytest.mark.parametrize(
    "air",
    [
        Air(drag=-0.1), Air(drag=math.nan), Air(magnus=math.inf), Air(spin_decay=-1.0),
        Air(spin_decay=math.nan), Air(drag=1e9), Air(drag=50.0),
        Air(saturation=-0.1), Air(saturation=math.nan),
    ],
)  # fmt: skip
def test_no_ball_flies_in_impossible_air(air):
    with pytest.raises(InputError, match="expected drag"):
        fly(random_balls(1), air, 0.1)


@pytest.mark.parametrize(
    "surface",
    [
        Surface(-0.1, 0.2), Surface(1.01, 0.2), Surface(math.nan, 0.2), Surface(0.9, -0.1),
        Surface(0.9, math.nan), Surface(0.9, math.inf),
    ],
)  # fmt: skip
def test_no_ball_bounces_off_an_impossible_surface(surface):
    with pytest.raises(InputError, match="restitution"):
        bounce(random_balls(1), UP, surface)


def test_nothing_that_is_not_finite_is_flown_or_bounced():
    lost = ball((math.nan, 0.0, 0.0))
    for move in (lambda: fly(lost, Air(), 0.1), lambda: bounce(lost, UP, Surface(0.9, 0.2))):
        with pytest.raises(InputError, match="finite"):
            move()


def test_flight_agrees_with_scipy_to_a_nanometre():
    air = Air()
    for k in range(5):
        balls = random_balls(5)
        thrown = Ball(balls.position[k], balls.velocity[k], balls.spin[k])

        def slope(time, state, spin=thrown.spin):
            v, spin = state[3:], spin * math.exp(-air.spin_decay * time)
            turn = np.cross(spin, v)
            ratio = BALL_RADIUS * np.linalg.norm(turn) / (v @ v)
            lift = air.magnus / (1.0 + air.saturation * ratio) * turn
            return np.concatenate([v, lift - air.drag * np.linalg.norm(v) * v - GRAVITY * UP])

        start = np.concatenate([thrown.position, thrown.velocity])
        wanted = solve_ivp(slope, (0, 1), start, method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
        flown = fly(thrown, air, 1.0)
        assert np.concatenate([flown.position, flown.velocity]) == pytest.approx(wanted, abs=2e-9)


def test_the_step_has_order_four():
    start = np.concatenate([np.zeros(3), [-9.0, 4.0, 5.0], [100.0, -200.0, 50.0]])
    ends = []
    for steps in (10, 20, 40, 1000):
        state = start[None].copy()
        kernels.fly(state, Air(0.3, 0.003), 1.0 / steps, steps)
        ends.append(state[0])
    errors = [np.linalg.norm(end[:6] - ends[-1][:6]) for end in ends[:3]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 3.6) & (orders < 4.6))


def test_the_written_and_the_compiled_acceleration_agree():
    balls, air = random_balls(20), Air()
    wanted = [
        kernels.acceleration(*v, *w, air) for v, w in zip(balls.velocity, balls.spin, strict=True)
    ]
    assert acceleration(balls, air) == pytest.approx(np.array(wanted), rel=1e-13, abs=1e-13)


def test_a_batch_of_any_shape_gives_the_bits_of_a_loop():
    flat = random_balls(6)
    batch = Ball(*(part.reshape(2, 3, 3) for part in (flat.position, flat.velocity, flat.spin)))
    table = Surface(0.9, 0.3)
    flown, bounced = fly(batch, Air(), 0.333), bounce(batch, UP, table)
    for k in range(6):
        one = Ball(flat.position[k], flat.velocity[k], flat.spin[k])
        for whole, alone in ((flown, fly(one, Air(), 0.333)), (bounced, bounce(one, UP, table))):
            row = np.unravel_index(k, (2, 3))
            assert np.array_equal(whole.position[row], alone.position)
            assert np.array_equal(whole.velocity[row], alone.velocity)
            assert np.array_equal(whole.spin[row], alone.spin)


def test_flight_leaves_its_argument_alone():
    thrown = random_balls(3)
    kept = thrown.velocity.copy()
    fly(thrown, Air(), 0.2)
    bounce(thrown, UP, Surface(0.9, 0.3))
    assert np.array_equal(thrown.velocity, kept)


def test_two_flights_in_a_row_are_one():
    thrown = random_balls(4)
    once = fly(thrown, Air(), 0.7)
    twice = fly(fly(thrown, Air(), 0.3), Air(), 0.4)
    assert twice.position == pytest.approx(once.position, abs=1e-9)


def test_no_time_changes_nothing():
    thrown = random_balls(3)
    assert np.array_equal(fly(thrown, Air(), 0.0).position, thrown.position)


@pytest.mark.parametrize("duration", [-0.1, math.nan, math.inf])
def test_an_impossible_duration_is_refused(duration):
    with pytest.raises(InputError, match="duration"):
        fly(random_balls(1), Air(), duration)


def calibrated_sphere(air):
    """Return a MuJoCo model of the ball in air.

    Its fluid model has drag rho C A without the half, and an added-mass term that gives a spinning
    sphere a lift of the wrong sign, half the displaced mass, which the Magnus coefficient makes up.
    """
    density = 1.2
    displaced = density * 4 / 3 * math.pi * BALL_RADIUS**3 / MASS
    blunt = air.drag * MASS / (density * math.pi * BALL_RADIUS**2)
    lift = 0.5 + air.magnus / displaced
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <option integrator="RK4" timestep="0.001" density="{density}" gravity="0 0 {-GRAVITY}"/>
      <worldbody><body><freejoint/>
        <geom type="sphere" size="{BALL_RADIUS}" mass="{MASS}" fluidshape="ellipsoid"
              fluidcoef="{blunt} 0 0 0 {lift}"/>
      </body></worldbody>
    </mujoco>""")


def test_flight_agrees_with_mujoco_to_half_a_micrometre():
    air = Air(spin_decay=0.0, saturation=0.0)  # its spin decays by another law, its lift is linear
    model, balls = calibrated_sphere(air), random_balls(3, seed=1)
    flown = fly(balls, air, 0.5)
    for k in range(3):
        data = mujoco.MjData(model)
        data.qpos[:3] = balls.position[k]
        data.qvel[:3], data.qvel[3:] = balls.velocity[k], balls.spin[k]
        mujoco.mj_step(model, data, 500)
        assert data.qpos[:3] == pytest.approx(flown.position[k], abs=5e-7)


def test_the_worked_bounce_comes_out_as_the_impulse_law_says():
    bounced = bounce(ball((4.0, 0.0, -2.5)), UP, Surface(0.896, 0.25))
    pull = 0.25 * 1.896 * 2.5
    assert bounced.velocity == pytest.approx([4.0 - pull, 0.0, 0.896 * 2.5], abs=1e-12)
    assert bounced.spin == pytest.approx([0.0, 1.5 * pull / BALL_RADIUS, 0.0], abs=1e-9)
    assert bounced.velocity[0] == pytest.approx(2.81, abs=0.01)
    assert bounced.spin[1] == pytest.approx(89.0, abs=0.2)


@given(velocities, rotations, velocities, surfaces)
@cheaply
def test_restitution_is_exact_on_any_surface(velocity, spin, direction, surface):
    if np.linalg.norm(direction) < 1e-3:
        return
    normal = unit(direction)
    before = ball(velocity, spin)
    after = bounce(before, normal, surface)
    approach = velocity @ normal
    kept = approach if approach >= 0.0 else -surface.restitution * approach
    assert after.velocity @ normal == pytest.approx(kept, abs=1e-12)


@given(velocities, rotations, surfaces)
@cheaply
def test_a_bounce_never_adds_energy_and_never_reverses_the_slip(velocity, spin, surface):
    before = ball(velocity, spin)
    after = bounce(before, UP, surface)
    assert kinetic(after) <= kinetic(before) * (1.0 + 1e-12) + 1e-12
    kept = slip(after, UP)
    assert kept @ slip(before, UP) >= -1e-9
    assert np.linalg.norm(kept) <= np.linalg.norm(slip(before, UP)) + 1e-12


@given(velocities, rotations, surfaces)
@cheaply
def test_a_bounce_keeps_the_angular_momentum_about_the_contact(velocity, spin, surface):
    before = ball(velocity, spin)
    change = about_contact(bounce(before, UP, surface), UP) - about_contact(before, UP)
    assert change == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_surface_that_grips_stops_the_slip_with_two_fifths_of_it():
    before = ball((4.0, -1.0, -2.5), (30.0, -40.0, 50.0))
    after = bounce(before, UP, Surface(0.9, 10.0))
    assert slip(after, UP) == pytest.approx(np.zeros(3), abs=1e-12)
    change = (after.velocity - before.velocity)[:2]
    assert change == pytest.approx(-0.4 * slip(before, UP)[:2], abs=1e-12)
    assert after.spin[2] == before.spin[2]


def test_a_ball_that_rolls_without_slip_is_not_turned():
    before = ball((4.0, 0.0, -2.5), (0.0, 4.0 / BALL_RADIUS, 0.0))
    after = bounce(before, UP, Surface(0.896, 0.25))
    assert after.velocity == pytest.approx([4.0, 0.0, 2.24], abs=1e-12)
    assert after.spin == pytest.approx(before.spin, abs=1e-9)


def test_a_ball_that_leaves_is_not_touched():
    before = ball((4.0, 0.0, 0.1), (1.0, 2.0, 3.0))
    after = bounce(before, UP, Surface(0.9, 0.25))
    assert np.array_equal(after.velocity, before.velocity)
    assert np.array_equal(after.spin, before.spin)


@given(velocities, rotations)
@cheaply
def test_left_and_right_are_mirror_images(velocity, spin):
    mirror, axial = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    table = Surface(0.9, 0.25)
    for move in (lambda b: fly(b, Air(), 0.3), lambda b: bounce(b, UP, table)):
        here = move(ball(velocity, spin))
        there = move(ball(mirror * velocity, axial * spin))
        assert there.position == pytest.approx(mirror * here.position, abs=1e-12)
        assert there.velocity == pytest.approx(mirror * here.velocity, abs=1e-12)
        assert there.spin == pytest.approx(axial * here.spin, abs=1e-9)

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rotorpong.drone import HOVER, Navdata, VelocityCommand
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, new_drone
from rotorpong.vision.flight_filter import ARDRONE2_ATTITUDE
from rotorpong.vision.own_motion import OdometryQuality, OwnMotion

START = np.array([-1.9, 0.0, 0.19])
PERIOD = 0.005  # s
GRAVITY = 9.81
QUALITY = OdometryQuality()


def motion_from(start=START, odometry=QUALITY):
    return OwnMotion(start, ARDRONE2_ATTITUDE, odometry)


def navdata(times, *, rates=None, force=None, velocity=None, attitude=None, height=0.95):
    n = len(times)

    def rows(value):
        return np.zeros((n, 3)) if value is None else np.broadcast_to(value, (n, 3)).copy()

    return Navdata(
        np.asarray(times, dtype=float),
        rows(rates),
        rows([0.0, 0.0, GRAVITY] if force is None else force),
        rows(attitude),
        rows(velocity),
        np.full(n, height),
        np.ones(n),
    )


def in_portions(data, sizes):
    """Cut navdata into portions."""
    at = 0
    for size in sizes:
        cut = slice(at, at + size)
        yield Navdata(*(getattr(data, name)[cut] for name in Navdata.__dataclass_fields__))
        at += size


def angle_between(a, b):
    return np.linalg.norm(Rotation.from_matrix(a.T @ b).as_rotvec())


def test_a_constant_turn_is_the_rotation_that_scipy_gives():
    times, rates = np.arange(0.0, 0.5, PERIOD), np.array([0.4, -0.7, 1.1])
    motion = motion_from()
    motion.add(navdata(times, rates=rates))
    for time in (0.0, 0.1, 0.2525, times[-1]):
        _, turned = motion.pose(time)
        assert angle_between(turned, Rotation.from_rotvec(rates * time).as_matrix()) < 1e-5


def leaning(times, lean, *, flow_sd=0.0, rng=None):
    """Return navdata of a drone without drag that hovers, then leans forward by `lean` (rad)."""
    rates = np.zeros((len(times), 3))
    rates[10:20, 1] = lean / (10 * PERIOD)
    pitch = lean * np.clip((times - times[9]) / (10 * PERIOD), 0.0, 1.0)
    pull = GRAVITY / np.cos(pitch)  # it keeps its height
    speed = PERIOD * np.cumsum(GRAVITY * np.tan(pitch))
    velocity = np.stack([speed, 0.0 * speed, 0.0 * speed], axis=1)
    noise = 0.0 if rng is None else flow_sd * rng.standard_normal(velocity.shape)
    attitude = np.stack([0.0 * pitch, pitch, 0.0 * pitch], axis=1)
    force = np.stack([0.0 * pull, 0.0 * pull, pull], axis=1)
    return velocity, navdata(
        times, rates=rates, force=force, velocity=velocity + noise, attitude=attitude
    )


def test_a_drone_that_leans_accelerates_as_its_rotors_pull():
    """In half a second at 0.1 rad by 0.4 m/s; without drag flow, gyro and pull agree."""
    times = np.arange(0.0, 0.5, PERIOD)
    velocity, data = leaning(times, 0.1)
    motion = motion_from(odometry=OdometryQuality(drag=0.0, drag_sd=0.01))
    motion.add(data)
    assert motion.velocity(times[-1], np.zeros(3))[0] == pytest.approx(velocity[-1, 0], rel=0.03)
    place, _ = motion.pose(times[-1])
    assert place[0] - START[0] == pytest.approx(PERIOD * velocity[:, 0].sum(), rel=0.05)


def test_a_noisy_flow_makes_no_noisy_velocity():
    """White noise of 0.1 m/s: over 100 samples 1 cm/s is left of it; over ten it would be 3."""
    rng, errors = np.random.default_rng(0), []
    times = np.arange(0.0, 0.5, PERIOD)
    for _ in range(40):
        velocity, data = leaning(times, 0.1, flow_sd=0.1, rng=rng)
        motion = motion_from(odometry=OdometryQuality(drag=0.0, drag_sd=0.01))
        motion.add(data)
        errors.append(motion.velocity(times[-1], np.zeros(3))[0] - velocity[-1, 0])
    assert np.sqrt(np.mean(np.square(errors))) < 0.02


def test_variances_of_the_velocity_are_those_of_its_errors():
    """40 hovering drones whose flow has a constant error too; 4 sigma of a variance are 90 %."""
    rng, errors, told = np.random.default_rng(1), [], 0.0
    times = np.arange(0.0, 0.5, PERIOD)
    for _ in range(40):
        start = 0.02 * rng.standard_normal(2)
        bias = 0.03 * rng.standard_normal(2)
        flow = np.zeros((len(times), 3))
        flow[:, :2] = start + bias + 0.1 * rng.standard_normal((len(times), 2))
        motion = motion_from(odometry=OdometryQuality(drag=0.0, drag_sd=1e-3))
        motion.add(navdata(times, velocity=flow))
        errors.append(motion.velocity(times[-1], np.zeros(3))[:2] - start)
        told = motion.velocity_variance(times[-1])[0]
    assert np.mean(np.square(errors)) < 1.9 * told


def test_a_point_off_the_middle_swings_with_the_body():
    times, lever = np.arange(0.0, 0.2, PERIOD), np.array([0.2, 0.0, 0.1])
    motion = motion_from()
    motion.add(navdata(times, rates=[0.0, 0.0, 1.0]))
    swung = motion.velocity(0.1, lever) - motion.velocity(0.1, np.zeros(3))
    c, s = np.cos(0.1), np.sin(0.1)
    assert swung == pytest.approx(0.2 * np.array([-s, c, 0.0]), abs=2e-3)


def test_a_kick_that_one_sample_shows_swings_nothing():
    times = np.arange(0.0, 0.2, PERIOD)
    rates = np.zeros((len(times), 3))
    rates[20] = [2.5, -2.5, 0.0]
    motion = motion_from()
    motion.add(navdata(times, rates=rates))
    lever = np.array([0.2, 0.0, 0.1])
    swung = motion.velocity(times[20], lever) - motion.velocity(times[20], np.zeros(3))
    assert swung == pytest.approx(np.zeros(3), abs=1e-9)


def test_portions_give_what_the_whole_gives():
    rng, times = np.random.default_rng(0), np.arange(0.0, 0.4, PERIOD)
    data = navdata(times)
    data = Navdata(
        data.times, rng.normal(0, 0.5, (80, 3)), data.acceleration, data.attitude,
        rng.normal(0, 0.5, (80, 3)), data.height, data.battery,
    )  # fmt: skip
    whole, parts = motion_from(), motion_from()
    whole.add(data)
    for portion in in_portions(data, (1, 2, 7, 20, 50)):
        parts.add(portion)
    for time in (0.013, 0.2, 0.39):
        for a, b in zip(whole.pose(time), parts.pose(time), strict=True):
            assert np.array_equal(a, b)


def test_a_kick_that_one_sample_shows_turns_nothing():
    times = np.arange(0.0, 0.2, PERIOD)
    rates = np.tile([0.1, 0.0, 0.0], (len(times), 1))
    calm, kicked = motion_from(), motion_from()
    calm.add(navdata(times, rates=rates))
    rates = rates.copy()
    rates[17] += [2.5, -2.5, 0.0]
    kicked.add(navdata(times, rates=rates))
    assert np.array_equal(calm.pose(0.195)[1], kicked.pose(0.195)[1])


def test_sonar_holds_the_height_over_floor_and_table():
    times = np.arange(0.0, 1.0, PERIOD)
    for ground, height in ((0.76, 0.95), (0.0, 0.19)):
        motion = motion_from()
        motion.add(navdata(times, velocity=[0.0, 0.0, 0.05], height=height))
        place, _ = motion.pose(times[-1])
        assert place[2] == pytest.approx(height - ground, abs=0.002)


def test_a_reading_is_the_mean_beyond_the_gyro():
    motion, times = motion_from(), np.arange(0.0, 0.1, PERIOD)
    reading = motion.add(navdata(times, attitude=[0.02, -0.01, 0.0]))
    assert reading.angles == pytest.approx([0.02, -0.01])
    assert reading.duration == pytest.approx(times[-1])
    assert motion.add(navdata([])) is None


def test_before_any_navdata_the_drone_is_where_it_started():
    place, turned = motion_from().pose(0.3)
    assert np.array_equal(place, START)
    assert np.array_equal(turned, np.eye(3))


@pytest.mark.parametrize(
    ("vehicle", "camera", "most_deg", "most_m"),
    [("tum_gazebo", "gazebo", 2.0, 0.12), ("ardrone2", "ardrone2_720p", 0.4, 0.16)],
)
def test_a_flown_serve_is_followed(vehicle, camera, most_deg, most_m):
    """4 sigma in a second: 0.43 degrees/sqrt(s) of unseen kicks; a flow's bias of 0.03 m/s."""
    spec = Spec("hover", camera=camera, vehicle=vehicle)
    stage = Stage(spec, spec.setting(), serve_source("human", 0), "evaluate")
    for index in range(4):
        drone, motion, last = new_drone(stage, index), motion_from(), 0.0
        while (seen := drone.observe()) is not None:
            motion.add(seen.navdata)
            last = seen.frame_time
            drone.command(VelocityCommand(0.5, 0.5, 0.1, 0.3) if seen.frame_time > 0.3 else HOVER)
        truth = drone.truth()
        tick = round(1000 * last)
        place, turned = motion.pose(last)
        true = rotation_from_quaternion(truth.attitude_path[tick])
        assert np.degrees(angle_between(turned, true)) < most_deg
        assert np.linalg.norm(place - truth.body_path[tick]) < most_m

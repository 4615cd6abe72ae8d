import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rotorpong.drone import HOVER, Navdata, VelocityCommand
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import Stage, new_drone
from rotorpong.vision.own_motion import OwnMotion

START = np.array([-1.9, 0.0, 0.19])
PERIOD = 0.005  # s


def navdata(times, *, rates=None, velocity=None, attitude=None, height=0.95):
    n = len(times)

    def rows(value):
        return np.zeros((n, 3)) if value is None else np.broadcast_to(value, (n, 3)).copy()

    return Navdata(
        np.asarray(times, dtype=float),
        rows(rates),
        np.zeros((n, 3)),
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
    motion = OwnMotion(START)
    motion.add(navdata(times, rates=rates))
    for time in (0.0, 0.1, 0.2525, times[-1]):
        _, turned = motion.pose(time)
        assert angle_between(turned, Rotation.from_rotvec(rates * time).as_matrix()) < 1e-5


def test_flying_forward_while_turning_is_a_circle():
    """Radius v / w; the trapezoid over 5 ms errs by less than a millimetre."""
    times, speed, turn = np.arange(0.0, 1.0, PERIOD), 2.0, 1.5
    motion = OwnMotion(START)
    motion.add(navdata(times, rates=[0.0, 0.0, turn], velocity=[speed, 0.0, 0.0]))
    angle, radius = turn * times[-1], speed / turn
    circle = START + radius * np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0])
    place, _ = motion.pose(times[-1])
    assert place[:2] == pytest.approx(circle[:2], abs=1e-2)
    assert motion.velocity(0.5)[:2] == pytest.approx(
        speed * np.array([np.cos(0.75), np.sin(0.75)]), abs=0.02
    )


def test_portions_give_what_the_whole_gives():
    rng, times = np.random.default_rng(0), np.arange(0.0, 0.4, PERIOD)
    data = navdata(times)
    data = Navdata(
        data.times, rng.normal(0, 0.5, (80, 3)), data.acceleration, data.attitude,
        rng.normal(0, 0.5, (80, 3)), data.height, data.battery,
    )  # fmt: skip
    whole, parts = OwnMotion(START), OwnMotion(START)
    whole.add(data)
    for portion in in_portions(data, (1, 2, 7, 20, 50)):
        parts.add(portion)
    for time in (0.013, 0.2, 0.39):
        for a, b in zip(whole.pose(time), parts.pose(time), strict=True):
            assert np.array_equal(a, b)


def test_a_kick_that_one_sample_shows_turns_nothing():
    times = np.arange(0.0, 0.2, PERIOD)
    rates = np.tile([0.1, 0.0, 0.0], (len(times), 1))
    calm, kicked = OwnMotion(START), OwnMotion(START)
    calm.add(navdata(times, rates=rates))
    rates = rates.copy()
    rates[17] += [2.5, -2.5, 0.0]
    kicked.add(navdata(times, rates=rates))
    assert np.array_equal(calm.pose(0.195)[1], kicked.pose(0.195)[1])


def test_sonar_holds_the_height_over_floor_and_table():
    times = np.arange(0.0, 1.0, PERIOD)
    for ground, height in ((0.76, 0.95), (0.0, 0.19)):
        motion = OwnMotion(START)
        motion.add(navdata(times, velocity=[0.0, 0.0, 0.05], height=height))
        place, _ = motion.pose(times[-1])
        assert place[2] == pytest.approx(height - ground, abs=0.006)  # drift / gain


def test_a_reading_is_the_mean_beyond_the_gyro():
    motion, times = OwnMotion(START), np.arange(0.0, 0.1, PERIOD)
    reading = motion.add(navdata(times, attitude=[0.02, -0.01, 0.0]))
    assert reading.angles == pytest.approx([0.02, -0.01])
    assert reading.duration == pytest.approx(times[-1])
    assert motion.add(navdata([])) is None


def test_before_any_navdata_the_drone_is_where_it_started():
    place, turned = OwnMotion(START).pose(0.3)
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
        drone, motion, last = new_drone(stage, index), OwnMotion(START), 0.0
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

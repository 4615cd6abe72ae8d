import math
from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rotorpong.conventions import BALL_RADIUS, GRAVITY, InputError
from rotorpong.drone import HOVER, Drone, Eyes, Frame, Navdata, Referee, VelocityCommand
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.ball import RUBBER, Air, Ball, bounce, fly
from rotorpong.physics.camera import ARDRONE2_360P, ARDRONE2_720P, GAZEBO, ideal, project, row_time
from rotorpong.physics.vehicle import NOISE_FREE_CASCADE, TUM_GAZEBO, TumGazebo
from rotorpong.world.batch import Cast, ServeBatch
from rotorpong.world.racket import HOME_BLADE, HOME_BODY, Racket
from rotorpong.world.serves import HUMAN, PLANE_X, Serve, crossing, draw, draw_at
from rotorpong.world.simulated_drone import Setting, SimulatedDrone
from rotorpong.world.truth_eyes import TruthEyes

NOISE_FREE = TumGazebo(NOISE_FREE_CASCADE)
CALM = Setting(NOISE_FREE, GAZEBO)
REAL = Setting(TUM_GAZEBO, GAZEBO)
AT_THE_RELEASE = (209, 257, 312)  # of serves whose first exposure rounds to tick 0 at 30 frames/s
LEFT = VelocityCommand(left=2.0)


def rng(seed):
    return np.random.default_rng(seed)


def drone(serve, setting=CALM, *, seed=0, tape=()):
    return SimulatedDrone(
        serve, setting, vehicle_rng=rng(seed), sensor_rng=rng(seed + 1000), tape=tape
    )


def aimed(left, up, seed=0):
    return draw_at(HUMAN, (left, up), rng(seed))


def thrown(position, velocity):
    return Serve(Ball(np.array(position, float), np.array(velocity, float), np.zeros(3)))


def flat(left, up):
    """Return a fast ball without a bounce, in vacuum, that passes the target nearly level.

    A slow one would fall on the hull, which reaches further out than the blade.
    """
    duration = (5.0 - PLANE_X) / 12.0
    rise = 0.8 * GRAVITY * duration
    height = HOME_BLADE[2] + up - rise * duration + GRAVITY / 2 * duration**2
    return replace(thrown([5.0, left, height], [-12.0, 0.0, rise]), air=Air(0.0, 0.0, 0.0))


def observed(flying, decide=lambda _: None):
    """Play a serve to its end; `decide` may command after each observation."""
    seen = []
    while (observation := flying.observe()) is not None:
        seen.append(observation)
        order = decide(observation)
        if order is not None:
            flying.command(order)
    return seen


def restless(seed):
    """Return a policy that commands something new at every other frame."""
    generator = rng(seed)

    def decide(_):
        order = VelocityCommand(*generator.uniform([-1, -1, -0.3, -1], [1, 1, 0.4, 1]).tolist())
        return order if generator.random() < 0.5 else None

    return decide


def recorded(flying, decide):
    """Play a serve and return what was observed and the tape of commands."""
    tape = []

    def remember(observation):
        order = decide(observation)
        if order is not None:
            tape.append((observation.arrival_time, order))
        return order

    return observed(flying, remember), tape


def paths(truth):
    return np.column_stack([truth.ball_path, truth.body_path, truth.blade_path])


def assert_same_path(one, other):
    """The end of a serve is noticed at the next frame, so paths may differ in length."""
    shorter = min(len(one.ball_path), len(other.ball_path))
    assert np.array_equal(paths(one)[:shorter], paths(other)[:shorter])
    assert abs(len(one.ball_path) - len(other.ball_path)) < 70
    assert one.verdict == other.verdict


def test_it_is_a_drone_and_a_referee_and_truth_has_eyes():
    flying = drone(aimed(0.0, 0.0))
    assert isinstance(flying, Drone)
    assert isinstance(flying, Referee)
    assert isinstance(TruthEyes(flying), Eyes)


def test_frames_come_thirty_times_a_second_and_time_never_runs_back():
    for setting in (REAL, replace(REAL, camera=ideal(ARDRONE2_720P))):
        for seed in range(5):
            seen = observed(drone(aimed(0.3, 0.1, seed), setting, seed=seed))
            times = np.array([o.frame_time for o in seen])
            arrivals = np.array([o.arrival_time for o in seen])
            assert times[0] > 0.0
            assert np.diff(times) == pytest.approx(1 / 30, abs=0.0011)
            assert (times[-1] - times[0]) * 30 == pytest.approx(len(seen) - 1, abs=0.04)
            delays = arrivals - times
            low, high = setting.camera.delay_s
            assert np.ptp(delays) < 1e-9
            assert low - 0.0006 <= delays[0] <= high + 0.0006
            for observation, arrival in zip(seen, arrivals, strict=True):
                assert observation.navdata.times.max(initial=0.0) <= arrival + 1e-12


def test_the_camera_delay_differs_between_serves():
    setting = replace(CALM, camera=ARDRONE2_720P)
    first = [drone(aimed(0.3, 0.1), setting, seed=seed).observe() for seed in range(12)]
    delays = [o.arrival_time - o.frame_time for o in first if o is not None]
    assert max(delays) - min(delays) > 0.02


def test_frames_are_late_by_jitter_and_lost_by_drops_within_four_sigma():
    camera = replace(ideal(ARDRONE2_720P), jitter_s=0.010, drop_share=0.2)
    late, lost, sent = [], 0, 0
    for seed in range(25):
        seen = observed(drone(aimed(0.3, 0.1, seed), replace(CALM, camera=camera), seed=seed))
        times = np.array([o.frame_time for o in seen])
        arrivals = np.array([o.arrival_time for o in seen])
        assert np.all(np.diff(arrivals) > 0.0)
        delays = arrivals - times
        late.extend(delays - delays.min())
        numbers = np.rint((times - times[0]) * 30.0)
        sent += int(numbers[-1])
        lost += int(numbers[-1]) + 1 - len(seen)
        assert np.ptp(delays) < 0.0101
    assert np.max(late) > 0.008
    assert abs(lost - 0.2 * sent) < 4 * np.sqrt(0.16 * sent)


def test_the_sensor_of_a_camera_leaves_the_flight_and_the_frame_times_of_a_steady_one():
    full = replace(ARDRONE2_360P, jitter_s=0.0, drop_share=0.0)
    one, other = (
        observed(drone(aimed(0.3, 0.1), replace(REAL, camera=camera), seed=3), restless(3))
        for camera in (full, ideal(full))
    )
    assert [o.frame_time for o in one] == [o.frame_time for o in other]
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.navdata.attitude, b.navdata.attitude)


def test_no_frame_arrives_before_its_last_row_is_exposed():
    slow = replace(ARDRONE2_360P, delay_s=(0.0, 0.0), jitter_s=0.0)
    for observation in observed(drone(aimed(0.3, 0.1), replace(CALM, camera=slow))):
        end = row_time(slow, observation.frame_time, np.array([359.0]))[0] + slow.exposure_s / 2
        assert observation.arrival_time >= end


@pytest.mark.parametrize("camera", [GAZEBO, ARDRONE2_360P], ids=["gazebo", "ardrone2_360p"])
def test_a_region_of_a_frame_is_a_crop_and_spares_the_rest(camera):
    one, other = (
        observed(drone(aimed(0.3, 0.1), replace(REAL, camera=camera), seed=1)) for _ in range(2)
    )
    for a, b in list(zip(one, other, strict=True))[5:8]:
        part = a.frame.region(300, 100, 380, 190)
        assert unrendered(a.frame)
        assert np.array_equal(part, b.frame.picture[100:190, 300:380])


def test_a_frame_of_a_full_sensor_can_be_looked_at_long_after():
    live = drone(aimed(0.3, 0.1), replace(REAL, camera=ARDRONE2_360P), seed=1)
    first = live.observe()
    at_once = first.frame.picture
    late = drone(aimed(0.3, 0.1), replace(REAL, camera=ARDRONE2_360P), seed=1)
    frames = observed(late)
    assert np.array_equal(frames[0].frame.picture, at_once)


def test_a_stream_codes_what_the_camera_took():
    camera = replace(ARDRONE2_360P, stream_mbit_s=1.0, drop_share=0.0)
    plain = replace(camera, stream_mbit_s=0.0)
    coded, taken = (
        observed(drone(aimed(0.3, 0.1), replace(REAL, camera=c), seed=1)) for c in (camera, plain)
    )
    errors = [
        a.frame.picture.astype(float) - b.frame.picture
        for a, b in zip(coded[:4], taken[:4], strict=True)
    ]
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 12.0
    assert np.array_equal(coded[2].frame.region(5, 6, 70, 80), coded[2].frame.picture[6:80, 5:70])


def test_a_camera_that_cannot_be_is_refused():
    with pytest.raises(InputError, match="readout_s"):
        drone(aimed(0.3, 0.1), replace(REAL, camera=replace(GAZEBO, readout_s=-0.01)))


def test_a_frame_at_the_release_itself_comes_a_tick_later():
    for seed in AT_THE_RELEASE:
        assert drone(aimed(0.3, 0.1), REAL, seed=seed).observe().frame_time == 0.001


@pytest.mark.parametrize("camera", [GAZEBO, ARDRONE2_720P], ids=["gazebo", "ardrone2_720p"])
def test_navdata_have_neither_gaps_nor_repeats_whatever_is_commanded(camera):
    setting, tape = replace(REAL, camera=camera), [(0.0, LEFT), (0.2031, LEFT)]
    for seed in (*range(4), *AT_THE_RELEASE):
        flying = drone(aimed(0.3, 0.1, seed), setting, seed=seed, tape=tape)
        parts = [o.navdata for o in observed(flying, restless(seed))]
        assert flying.last_navdata is not None
        times = np.concatenate([part.times for part in [*parts, flying.last_navdata]])
        assert times == pytest.approx(0.005 * np.arange(len(times)), abs=1e-12)
        assert times[-1] > len(flying.truth().ball_path) * 0.001 - 0.007


def test_navdata_do_not_depend_on_how_the_serve_is_cut_into_frames():
    def everything(fps):
        setting = replace(REAL, camera=replace(GAZEBO, frames_per_second=fps))
        flying = drone(aimed(0.3, 0.1), setting, tape=[(0.1, LEFT), (0.3, HOVER)])
        parts = [o.navdata for o in observed(flying)]
        return [np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Navdata)]

    for slow, fast in zip(everything(30.0), everything(77.0), strict=True):
        shorter = min(len(slow), len(fast))
        assert np.array_equal(slow[:shorter], fast[:shorter])


def test_a_command_acts_from_the_instant_it_is_given():
    flying, still = drone(aimed(0.4, 0.2), seed=3), drone(aimed(0.4, 0.2), seed=3)
    given = []

    def once(observation):
        if len(given) == 0 and observation.arrival_time > 0.3:
            given.append(round(observation.arrival_time * 1000))
            return LEFT
        return None

    observed(flying, once)
    moved, stayed = flying.truth().body_path, still.truth().body_path
    assert np.array_equal(moved[: given[0] + 1], stayed[: given[0] + 1])
    later = slice(given[0] + 15, min(len(moved), len(stayed)))
    assert np.all(moved[later, 1] > stayed[later, 1])


def test_commands_are_clipped_to_the_vehicles_limits():
    flying = drone(aimed(0.0, 0.0))
    sent = flying.command(VelocityCommand(9.0, -9.0, 9.0, -9.0))
    assert sent == VelocityCommand(2.0, -2.0, 0.5, -1.5)
    assert flying.command(VelocityCommand(0.5, -0.25, 0.125, 1.0)) == VelocityCommand(
        0.5, -0.25, 0.125, 1.0
    )


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_not_finite_is_refused_and_the_serve_goes_on(bad):
    flying, undisturbed = drone(aimed(0.3, 0.0), REAL), drone(aimed(0.3, 0.0), REAL)
    for f in fields(VelocityCommand):
        flying.observe()
        with pytest.raises(InputError, match="finite"):
            flying.command(replace(HOVER, **{f.name: bad}))
    assert_same_path(flying.truth(), undisturbed.truth())


@dataclass(frozen=True)
class Lost:
    """A user's vehicle that loses itself: one number of its path, in the middle, is none."""

    bad: float
    column: str
    limits = TUM_GAZEBO.limits
    sensor_noise = TUM_GAZEBO.sensor_noise
    name = "lost"

    def start(self, position, generator):
        return TUM_GAZEBO.start(position, generator)

    def advance(self, state, command, *, ticks, new_command):
        after, track = TUM_GAZEBO.advance(state, command, ticks=ticks, new_command=new_command)
        getattr(track, self.column)[..., track.position.shape[-2] // 2, 1] = self.bad
        return after, track


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("column", ["position", "quaternion"])
def test_a_vehicle_whose_path_is_not_finite_is_refused_alone_and_in_a_batch(column, bad):
    setting, serve = Setting(Lost(bad, column), GAZEBO), aimed(0.0, 0.0)
    with pytest.raises(InputError, match="finite poses"):
        drone(serve, setting).observe()
    with pytest.raises(InputError, match=r"row \d: .*finite poses"):
        ServeBatch(setting, [Cast(serve, rng(0), rng(1))] * 2).advance()


def test_a_ball_that_is_not_finite_is_refused():
    with pytest.raises(InputError, match="finite"):
        drone(thrown([1.0, math.nan, 0.3], [-4.0, 0.0, 1.0]))


def test_a_tape_replays_to_the_bit_with_the_same_camera_or_another():
    for seed in range(6):
        serve = aimed(0.2, 0.1, seed)
        live = drone(serve, REAL, seed=seed)
        seen, tape = recorded(live, restless(seed))
        assert len(tape) > 5
        again = drone(serve, REAL, seed=seed, tape=tape)
        replayed = observed(again)
        assert np.array_equal(paths(again.truth()), paths(live.truth()))
        assert again.verdict() == live.verdict()
        for old, new in zip(seen, replayed, strict=True):
            for f in fields(Navdata):
                assert np.array_equal(getattr(old.navdata, f.name), getattr(new.navdata, f.name))
        other = drone(serve, replace(REAL, camera=ARDRONE2_720P), seed=seed, tape=tape)
        observed(other)
        assert_same_path(other.truth(), live.truth())
        assert_same_path(drone(serve, REAL, seed=seed, tape=tape).truth(), live.truth())


def test_a_command_at_or_just_after_the_release_replays_too():
    serve = aimed(0.2, 0.1)
    for seed in (0, *AT_THE_RELEASE):
        live = drone(serve, REAL, seed=seed)
        live.command(LEFT)
        again = drone(serve, REAL, seed=seed, tape=[(0.0, LEFT)])
        assert_same_path(again.truth(), live.truth())
        live = drone(serve, REAL, seed=seed)
        first = live.observe()
        live.command(LEFT)
        again = drone(serve, REAL, seed=seed, tape=[(first.arrival_time, LEFT)])
        assert_same_path(again.truth(), live.truth())


def test_the_same_seeds_give_the_same_serve_and_others_do_not():
    one, two, other = (drone(aimed(0.3, 0.1), REAL, seed=seed) for seed in (5, 5, 6))
    assert np.array_equal(paths(one.truth()), paths(two.truth()))
    assert not np.array_equal(one.truth().body_path[:500], other.truth().body_path[:500])


def test_a_ball_aimed_at_the_middle_of_a_hovering_blade_hits_its_middle():
    for seed in range(5):
        serve = aimed(0.0, 0.0, seed)
        truth = drone(serve).truth()
        assert truth.verdict.outcome == "hit"
        assert truth.verdict.contact_offset == pytest.approx(0.0, abs=1e-4)
        assert truth.verdict.contact_time == pytest.approx(crossing(serve)[0], abs=1e-5)
        assert truth.miss_distance == truth.time_error == 0.0
        assert truth.contacts[-1].solid == "blade" or truth.contacts[-2].solid == "blade"


def test_the_contact_offset_is_counted_in_semi_axes():
    verdict = drone(aimed(0.05, -0.04)).verdict()
    wanted = math.hypot(0.05 / 0.075, 0.04 / 0.0785)
    assert verdict.contact_offset == pytest.approx(wanted, abs=1e-4)


def test_a_ball_below_the_blade_meets_the_hull():
    truth = drone(aimed(0.0, -0.16)).truth()
    assert truth.verdict.outcome == "hull"
    assert truth.verdict.contact_time is None
    assert truth.contacts[-1].solid == "hull"


def test_a_ball_far_from_a_hovering_blade_is_a_miss():
    truth = drone(aimed(0.4, 0.1)).truth()
    assert truth.verdict.outcome == "miss"
    assert truth.time_error is None
    assert truth.landing_x is None
    gap = math.hypot(0.4 - 0.07, 0.1) - BALL_RADIUS
    assert 0.6 * gap < truth.miss_distance < gap


def test_a_ball_that_passes_within_five_centimetres_is_a_near_hit():
    near, far = (drone(flat(0.0, up)).truth() for up in (0.13, 0.17))
    assert near.verdict.outcome == "near_hit"
    assert 0.0 < near.miss_distance < 0.05 < far.miss_distance
    assert far.verdict.outcome == "miss"


@pytest.mark.parametrize(("left", "sign"), [(0.35, 1), (0.15, -1)], ids=["late", "early"])
def test_a_blade_there_within_a_tenth_of_a_second_is_a_near_hit(left, sign):
    serve, in_time_only, outcomes = flat(left, 0.05), 0, set()
    for start in np.arange(0.0, 0.55, 0.01):
        truth = drone(serve, tape=[(float(start), LEFT)]).truth()
        outcome, late = truth.verdict.outcome, truth.time_error
        outcomes.add(outcome)
        if truth.miss_distance >= 0.05:
            in_time = late is not None and abs(late) <= 0.1
            assert outcome == ("near_hit" if in_time else "miss")
            in_time_only += in_time and sign * late > 0.0
    assert outcomes == {"hit", "near_hit", "miss"}
    assert in_time_only > 0


def test_the_sign_and_size_of_lateness_follow_the_start_of_the_move():
    serve, lags = flat(0.35, 0.05), []
    for start in np.arange(0.0, 0.4, 0.01):
        late = drone(serve, tape=[(float(start), LEFT)]).truth().time_error
        if late is not None and late > 0.0:
            lags.append((start, late))
    starts, lates = np.array(lags).T
    assert len(lags) > 5
    assert np.diff(lates) == pytest.approx(np.diff(starts), abs=0.0021)


def test_a_drone_driven_into_the_floor_or_the_table_is_at_fault():
    high = thrown([2.0, 0.0, 30.0], [0.0, 0.0, 0.0])
    down = drone(high, tape=[(0.0, VelocityCommand(up=-0.5))]).truth()
    assert down.verdict.outcome == "fault"
    assert down.body_path[-1, 2] == pytest.approx(-0.71, abs=0.03)
    over = drone(high, tape=[(0.0, VelocityCommand(forward=1.0, up=-0.5))]).truth()
    assert over.verdict.outcome == "fault"
    assert over.body_path[-1, 2] == pytest.approx(0.05, abs=0.03)


def test_a_serve_ends_by_three_seconds():
    truth = drone(thrown([2.0, 0.0, 30.0], [0.0, 0.0, 0.0])).truth()
    assert truth.verdict.outcome == "miss"
    assert len(truth.ball_path) == 3001
    for seed in range(5):
        assert len(drone(draw(HUMAN, rng(seed))).truth().ball_path) < 3001


def test_a_ball_on_the_floor_or_behind_the_drone_ends_the_serve():
    fallen = drone(thrown([1.5, 0.0, 0.3], [2.0, 0.0, 0.0])).truth()
    assert fallen.contacts[-1].solid == "floor"
    passed = drone(thrown([1.0, 1.0, 0.5], [-9.0, 0.0, 1.0])).truth()
    assert passed.contacts == ()
    assert HOME_BODY[0] - 0.9 < passed.ball_path[-1, 0] < HOME_BODY[0] - 0.5


def test_truth_and_verdict_play_the_serve_to_its_end_and_stay_the_same():
    flying = drone(aimed(0.0, 0.0))
    assert flying.verdict().outcome == "hit"
    assert flying.verdict() == flying.truth().verdict
    assert np.array_equal(paths(flying.truth()), paths(flying.truth()))


def test_after_the_end_there_is_nothing_to_observe_ever():
    flying = drone(aimed(0.0, 0.0))
    observed(flying)
    last = flying.last_navdata
    assert flying.observe() is None
    assert flying.observe() is None
    assert flying.last_navdata is last
    judged = drone(aimed(0.0, 0.0))
    judged.observe()
    judged.verdict()
    assert judged.observe() is None


def test_truth_starts_at_home_at_the_release():
    serve = aimed(0.3, 0.0)
    truth = drone(serve, REAL).truth()
    assert np.array_equal(truth.ball_path[0], serve.ball.position)
    assert truth.body_path[0] == pytest.approx(np.array(HOME_BODY))
    assert truth.blade_path[0] == pytest.approx(np.array(HOME_BLADE))
    assert len(truth.ball_path) == len(truth.body_path) == len(truth.blade_path)


def test_in_the_world_the_ball_meets_its_target_whatever_the_drone_does():
    serve = aimed(0.35, -0.1)
    path = drone(serve, REAL, tape=[(0.0, VelocityCommand(left=-1.0))]).truth().ball_path
    i = int(np.argmax(path[:, 0] < PLANE_X))
    f = (path[i - 1, 0] - PLANE_X) / (path[i - 1, 0] - path[i, 0])
    there = path[i - 1] + f * (path[i] - path[i - 1])
    assert there[1:] == pytest.approx([0.35, HOME_BLADE[2] - 0.1], abs=2e-5)  # chord for arc


def test_blackout_changes_the_pictures_and_nothing_else():
    for camera in (GAZEBO, ARDRONE2_720P):
        lit, dark = (
            drone(aimed(0.3, 0.1), replace(REAL, camera=camera, blackout=blackout))
            for blackout in (False, True)
        )
        seen, unseen = observed(lit, restless(1)), observed(dark, restless(1))
        for bright, black in zip(seen, unseen, strict=True):
            assert (bright.frame_time, bright.arrival_time) == (
                black.frame_time,
                black.arrival_time,
            )
            assert np.array_equal(bright.navdata.attitude, black.navdata.attitude)
            assert (black.frame.width, black.frame.height) == (camera.width_px, camera.height_px)
        picture = unseen[3].frame.picture
        assert picture.shape == (camera.height_px, camera.width_px, 3)
        assert picture.dtype == np.uint8
        assert not picture.any()
        assert seen[3].frame.picture.any()
        assert seen[3].frame.picture.shape == picture.shape
        assert np.array_equal(paths(lit.truth()), paths(dark.truth()))


def unrendered(frame: Frame) -> bool:
    return frame._picture is None


def test_a_frame_is_rendered_when_somebody_looks_and_only_once():
    seen = observed(drone(aimed(0.3, 0.1)))
    assert all(unrendered(observation.frame) for observation in seen)
    first = seen[2].frame.picture
    assert first is seen[2].frame.picture
    assert [unrendered(o.frame) for o in seen].count(False) == 1


def resimulated(order, ticks, seed, camera):
    """Return body path, camera path and camera axes under one order, from the vehicle alone."""
    vehicle = TUM_GAZEBO
    state = vehicle.start(np.array(HOME_BODY), rng(seed))
    track = vehicle.advance(state, np.array(order), ticks=ticks, new_command=True)[1]
    pitch = math.radians(camera.camera_pitch_deg)
    forward = [math.cos(pitch), 0.0, math.sin(pitch)]
    down = [math.sin(pitch), 0.0, -math.cos(pitch)]
    turns = Rotation.from_quat(track.quaternion, scalar_first=True)
    axes = turns.as_matrix() @ np.column_stack([[0.0, -1.0, 0.0], down, forward])
    return track.position, track.position + turns.apply(np.array(camera.position_m)), axes


def is_shown(camera, position):
    """Tell whether a point of the camera frame is in the picture, far from the lens's folds."""
    x, y = project(camera, position)
    inside = 0 <= x <= camera.width_px - 1 and 0 <= y <= camera.height_px - 1
    return bool(inside and np.abs(position[:2] / position[2]).max() < 0.9)


@pytest.mark.parametrize("pitch_deg", [0.0, 15.0])
@pytest.mark.parametrize("camera", [GAZEBO, ARDRONE2_720P], ids=["gazebo", "ardrone2_720p"])
def test_truth_eyes_see_the_ball_where_it_is_in_the_axes_of_the_camera(camera, pitch_deg):
    order, camera = [0.8, 0.5, 0.2, 0.6], replace(camera, camera_pitch_deg=pitch_deg)
    flying = drone(aimed(0.3, 0.1), replace(REAL, camera=camera), seed=4)
    flying.command(VelocityCommand(*order))
    eyes, answers = TruthEyes(flying), []
    while (observation := flying.observe()) is not None:
        answers.append((observation.frame_time, eyes.see(observation)))
    truth = flying.truth()
    body, eye, axes = resimulated(order, len(truth.ball_path) - 1, 4, camera)
    assert np.array_equal(body, truth.body_path)
    apart = truth.ball_path - eye
    for time, estimate in answers:
        i = round(time * 1000)
        assert (estimate is not None) == is_shown(camera, axes[i].T @ apart[i])
        if estimate is None:
            continue
        assert estimate.time == time
        assert estimate.position == pytest.approx(axes[i].T @ apart[i], abs=1e-9)
        velocity = axes[i].T @ (apart[i + 1] - apart[i - 1]) / 0.002
        assert estimate.velocity == pytest.approx(velocity, abs=0.15)
        assert not estimate.covariance.any()
    assert 3 < sum(estimate is not None for _, estimate in answers) < len(answers)


@pytest.mark.parametrize("camera", [GAZEBO, ideal(ARDRONE2_720P)], ids=["gazebo", "ardrone2_720p"])
def test_the_picture_shows_the_ball_where_truth_eyes_see_it(camera):
    flying = drone(aimed(0.1, 0.1), replace(REAL, camera=camera), seed=2)
    flying.command(VelocityCommand(left=0.5, yaw_rate=0.3))
    eyes, checked = TruthEyes(flying), 0
    while (observation := flying.observe()) is not None:
        estimate = eyes.see(observation)
        if estimate is None or observation.frame_time < 0.4 or checked == 3:
            continue
        place = project(camera, estimate.position)
        radius = camera.focal_length_px[0] * BALL_RADIUS / estimate.position[2]
        blue, _, red = np.moveaxis(observation.frame.picture.astype(float), -1, 0)
        rows, columns = np.nonzero(red - blue > 90.0)
        near = np.hypot(columns - place[0], rows - place[1]) < 2.0 * radius
        assert columns[near].mean() == pytest.approx(place[0], abs=0.5)
        assert rows[near].mean() == pytest.approx(place[1], abs=0.5)
        assert near.sum() == pytest.approx(math.pi * radius**2, rel=0.2)
        checked += 1
    assert checked == 3


def test_a_rubber_racket_returns_a_fast_ball_and_cardboard_does_not():
    serve = thrown([0.3, 0.0, 0.25], [-20.0, 0.0, 1.3])
    rubber = drone(serve, replace(CALM, racket=Racket(RUBBER))).truth()
    cardboard = drone(serve).truth()
    assert rubber.verdict.outcome == cardboard.verdict.outcome == "hit"
    assert cardboard.landing_x is None
    contact = next(c for c in rubber.contacts if c.solid == "blade")
    struck = Ball(contact.position, contact.velocity, np.zeros(3))
    returned = bounce(struck, np.array([1.0, 0.0, 0.0]), RUBBER)
    low, high = 0.05, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        above = fly(returned, Air(), middle).position[2] > BALL_RADIUS
        low, high = (middle, high) if above else (low, middle)
    landing = fly(returned, Air(), low).position
    assert rubber.landing_x == pytest.approx(landing[0], abs=1e-5)
    assert 0.0 < rubber.landing_x < 1.37


def test_a_return_that_does_not_reach_the_other_side_has_no_landing():
    slow = drone(aimed(0.0, 0.0), replace(CALM, racket=Racket(RUBBER))).truth()
    assert slow.verdict.outcome == "hit"
    assert slow.landing_x is None


def test_navdata_come_late_and_none_is_lost():
    """The AR.Drone's are 12 ms old or older; those of the simulated drone come at once."""
    for vehicle, delay in ((ARDRONE2, 0.012), (TUM_GAZEBO, 0.0)):
        drone = SimulatedDrone(
            draw(HUMAN, np.random.default_rng(0)),
            Setting(vehicle, GAZEBO),
            vehicle_rng=np.random.default_rng(1),
            sensor_rng=np.random.default_rng(2),
        )
        times = []
        while (seen := drone.observe()) is not None:
            times.append(seen.navdata.times)
            newest = seen.arrival_time - seen.navdata.times[-1]
            assert delay - 1e-9 <= newest < delay + 0.005
        times = np.concatenate([*times, drone.last_navdata.times])
        assert np.diff(times) == pytest.approx(0.005)
        assert times[0] == 0.0

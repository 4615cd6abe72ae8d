"""Every randomised trial has a world of its own, and nothing else of the game changes."""

from dataclasses import fields, replace

import numpy as np
import pytest

from rotorpong.conventions import InputError, UnsolvableServeError
from rotorpong.drone import HOVER
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.randomize import (
    AIR_RANGES,
    TABLE_RANGES,
    draw_camera,
    draw_medium,
    draw_trial,
)
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serve_files import write_serves
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import VEHICLES, Spec
from rotorpong.lab.trial import Stage, meet
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.ball import Air, Surface
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO
from rotorpong.physics.vehicle import TUM_GAZEBO
from rotorpong.vision import PaperEyes
from rotorpong.world.serves import HUMAN, Medium, crossing, draw_at, obeys_rules

REAL = Spec("hover", vehicle="ardrone2", camera="ardrone2_720p", randomize=True)


def rng(seed=0):
    return np.random.default_rng(seed)


def met(spec, index):
    stage = Stage(spec, spec.setting(), serve_source(spec.serves, spec.seed), "evaluate")
    return meet(stage, index, trial_generators(spec.seed, "evaluate", index))


def test_two_workers_draw_what_one_draws_to_the_bit():
    spec = replace(REAL, player="paper", eyes="truth")
    assert evaluate(spec, 11, workers=2) == evaluate(spec, 11)


def test_a_randomised_game_is_another_game_and_its_own_again():
    plain, one, again = (evaluate(replace(REAL, randomize=r), 3) for r in (False, True, True))
    assert one == again
    assert [r.miss_distance for r in one] != [r.miss_distance for r in plain]


def test_without_the_flag_the_world_is_the_nominal_one():
    for name in VEHICLES:
        spec = Spec("hover", vehicle=name)
        serve, drone = met(spec, 5)
        source = serve_source("human", 0)
        nominal = source(5, trial_generators(0, "evaluate", 5).serve)
        assert np.array_equal(serve.ball.velocity, nominal.ball.velocity)
        assert drone.camera is spec.camera_profile()


def test_the_target_is_that_of_the_plain_serve():
    for index in range(5):
        drawn, plain = (met(replace(REAL, randomize=r), index)[0] for r in (True, False))
        assert drawn.target == plain.target


@pytest.mark.parametrize("serves", ["human", "constant"])
def test_every_serve_is_solved_for_its_own_ball(serves):
    spec = replace(REAL, serves=serves)
    thrown = [met(spec, index)[0] for index in range(25)]
    assert len({(serve.air, serve.table) for serve in thrown}) == 25
    for serve in thrown:
        assert obeys_rules(serve)
        if serve.target is not None:
            _, state = crossing(serve)
            assert state[1:3] == pytest.approx(np.add(serve.target, (0.0, 0.35)), abs=1e-4)


def test_a_serve_of_a_file_keeps_its_ball_while_everything_else_is_drawn(tmp_path):
    """Its drag, restitution and friction were measured with it: others would land elsewhere."""
    own = [met(REAL, index)[0] for index in range(2)]
    write_serves(tmp_path / "serves.csv", own)
    for index in range(3):
        serve, drone = met(replace(REAL, serves=str(tmp_path / "serves.csv")), index)
        assert (serve.air.drag, serve.table) == (own[index % 2].air.drag, own[index % 2].table)
        assert np.array_equal(serve.ball.velocity, own[index % 2].ball.velocity)
        assert drone.vehicle == met(REAL, index)[1].vehicle != ARDRONE2
        assert drone.camera != ARDRONE2_720P


def test_a_ball_that_cannot_be_thrown_at_the_target_is_drawn_again():
    """No serve of seed 0 reaches this target with a ball so slow on a table so dead."""
    dead = Medium(Air(0.11, 0.003), Surface(0.8, 0.15))
    with pytest.raises(UnsolvableServeError):
        draw_at(replace(HUMAN, medium=dead), (0.4, 0.2), rng())
    tried = []

    def serves(_, generator, medium):
        tried.append(dead if not tried else medium)
        return draw_at(replace(HUMAN, medium=tried[-1]), (0.4, 0.2), generator)

    stage = Stage(REAL, REAL.setting(), serves, "evaluate")
    generators = replace(trial_generators(0, "evaluate", 0), serve=rng())
    serve, _ = meet(stage, 0, generators)
    assert len(tried) >= 2
    assert serve.target == (0.4, 0.2)
    assert (serve.air, serve.table) == tried[-1] != dead


def test_balls_cover_their_ranges_evenly():
    drawn = [draw_medium(rng(seed)) for seed in range(400)]
    for part, ranges in (("air", AIR_RANGES), ("table", TABLE_RANGES)):
        for name, (low, high) in ranges.items():
            values = np.array([getattr(getattr(m, part), name) for m in drawn])
            share = (values - low) / (high - low)
            assert 0.0 <= share.min() < share.max() <= 1.0
            assert share.mean() == pytest.approx(0.5, abs=4 * np.sqrt(1 / 12 / 400))  # 4 sigma


def test_a_drawn_camera_is_nearly_the_nominal_one():
    for seed in range(100):
        camera = draw_camera(ARDRONE2_720P, rng(seed))
        ratio = np.divide(camera.focal_length_px, ARDRONE2_720P.focal_length_px)
        assert ratio[0] == pytest.approx(ratio[1])
        assert abs(ratio[0] - 1.0) <= 0.015
        assert np.abs(np.subtract(camera.center_px, ARDRONE2_720P.center_px)).max() <= 8.0
        assert np.abs(np.subtract(camera.position_m, ARDRONE2_720P.position_m)).max() <= 0.005
        assert abs(camera.camera_pitch_deg) <= 0.5
        assert camera.delay_s[1] / camera.delay_s[0] == pytest.approx(0.130 / 0.075)
        assert camera.distortion == ARDRONE2_720P.distortion
        assert camera.readout_s != ARDRONE2_720P.readout_s
    drawn = draw_camera(GAZEBO, rng())
    assert drawn.delay_s == (0.0, 0.0)
    assert drawn.is_ideal


def test_the_eyes_are_told_the_nominal_camera():
    _, drone = met(REAL, 0)
    assert drone.camera != ARDRONE2_720P
    told = replace(REAL, eyes="paper").make_eyes(drone, ARDRONE2_720P)
    assert isinstance(told, PaperEyes)
    observation = drone.observe()
    drone.command(HOVER)
    knowing = replace(REAL, eyes="paper").make_eyes(drone)
    seen, known = told.see(observation), knowing.see(observation)
    assert (seen is None) == (known is None)
    assert seen is None or not np.array_equal(seen.position, known.position)


def test_each_part_draws_from_a_stream_of_its_own():
    setting = Spec(vehicle="ardrone2").setting()
    one, ball = draw_trial(setting, rng(3))
    two, same_ball = draw_trial(replace(setting, vehicle=TUM_GAZEBO), rng(3))
    first = ball()
    assert first == same_ball()
    assert (one.camera, one.scene) == (two.camera, two.scene)
    other, other_ball = draw_trial(setting, rng(4))
    assert first != other_ball()
    assert first != ball()  # the next, where the first cannot be thrown
    assert len({one.camera, other.camera}) == len({one.scene, other.scene}) == 2
    assert one.vehicle != other.vehicle
    assert (one.racket, one.blackout) == (setting.racket, setting.blackout)


def test_the_looks_differ_from_room_to_room_but_the_ball_stays_orange():
    setting = Spec(vehicle="ardrone2").check().setting()
    rooms = {draw_trial(setting, rng(seed))[0].scene for seed in range(20)}
    assert len(rooms) == 20
    assert all(blue < green < red for blue, green, red in (room.ball for room in rooms))


class Fixed:
    """A vehicle of one's own that has no others of its kind."""

    name = "fixed"
    limits = ARDRONE2.limits
    sensor_noise = ARDRONE2.sensor_noise
    start = staticmethod(ARDRONE2.start)
    advance = staticmethod(ARDRONE2.advance)


def test_a_vehicle_without_ranges_cannot_be_randomised():
    assert Spec("hover", vehicle=Fixed()).check()
    with pytest.raises(InputError, match=r"vehicle 'fixed': expected one with randomized\(rng\)"):
        Spec("hover", vehicle=Fixed(), randomize=True).check()


@pytest.mark.parametrize("name", VEHICLES)
def test_every_vehicle_that_ships_can_be_randomised(name):
    spec = Spec("hover", vehicle=name, randomize=True).check()
    vehicles = [draw_trial(spec.setting(), rng(seed))[0].vehicle for seed in range(2)]
    assert vehicles[0] != vehicles[1]
    assert [v.name for v in vehicles] == [name] * 2
    nominal = VEHICLES[name]
    assert all(
        getattr(vehicles[0], f.name) == getattr(nominal, f.name)
        for f in fields(nominal)
        if f.name in ("settings", "loop", "raw")
    )

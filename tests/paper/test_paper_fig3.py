import json

import numpy as np
import pytest

from rotorpong.drone import HOVER
from rotorpong.lab.report.film import circle_in_picture
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper import fig3
from rotorpong.paper.findings import Scale
from rotorpong.paper.snapshot import as_text
from rotorpong.physics.camera import GAZEBO
from rotorpong.vision.paper_eyes import PaperEyes
from rotorpong.world.render import ball_coverage
from rotorpong.world.simulated_drone import eye_of

SPEC = Spec("hover")
STAGE = stage_of(SPEC)
GREY = np.full((fig3.WINDOW[1], fig3.WINDOW[0], 3), 90, np.uint8)
ROWS = [[100.0, 50.0, 5.0, 100.3, 50.4, 9.0], [100.0, 50.0, 5.0], [9.0, 9.0, 2.0, 90.0, 9.0, 4.0],
        [20.0, 20.0, 8.0, 20.0, 20.5, 15.4]]  # fmt: skip


def made():
    frame = {"time_s": 0.4, "picture": as_text(GREY), "circle": [40.0, 30.0, 9.0]}
    strip = {"bounce_s": 0.45, "frames": [frame, {**frame, "circle": None, "time_s": 0.5}]}
    return {**dict.fromkeys(fig3.VIEWS, ROWS), "strip": strip}


def test_circles_are_those_of_the_paper_s_eyes():
    drone = new_drone(STAGE, 0)
    eyes, compared = PaperEyes(drone.camera, whole_pixels=False), 0
    while (seen := drone.observe()) is not None:
        drone.command(HOVER)
        if (estimate := eyes.see(seen)) is None:
            continue
        center, radius = circle_in_picture(GAZEBO, estimate.position)
        circle = fig3.circle_in(seen.frame.picture)
        assert circle is not None
        found = (circle.x_px, circle.y_px, 0.5 * circle.diameter_px)
        np.testing.assert_allclose(found, [*center, radius], rtol=0, atol=1e-6)
        compared += 1
    assert compared > 10


def test_the_exact_disc_is_what_the_ball_covers():
    drone = new_drone(STAGE, 0)
    seen = drone.observe()
    assert seen is not None
    tick = round(1000.0 * seen.frame_time)
    truth = drone.truth()
    pose = np.concatenate([truth.body_path[tick], truth.attitude_path[tick]])
    share = ball_coverage(GAZEBO, *eye_of(GAZEBO, pose), truth.ball_path[tick])
    rows, columns = np.indices(share.shape)
    area = share.sum()
    covered = [(columns * share).sum() / area, (rows * share).sum() / area, np.sqrt(area / np.pi)]
    np.testing.assert_allclose(fig3.exact_disc(drone, seen.frame_time), covered, atol=0.05)


def test_through_a_rolling_shutter_the_ball_is_taken_when_its_row_was():
    stage = stage_of(fig3.VIEWS["ardrone2_720p"])
    drone = new_drone(stage, 0)
    seen = drone.observe()
    assert seen is not None
    disc = fig3.exact_disc(drone, seen.frame_time)
    late = (disc[1] + 0.5) / 720.0 - 0.5
    time = seen.frame_time + late * drone.camera.readout_s
    np.testing.assert_allclose(
        disc, fig3.disc_of_sphere(drone.camera, fig3.true_state(drone, time)[:3]), atol=0.02
    )
    assert abs(time - seen.frame_time) > 1e-4


def test_found_missed_and_elsewhere_are_told_apart():
    values = fig3.numbers(ROWS, 3.0, 6.0)
    assert (values["frames"], values["elsewhere"]) == (4, 1)
    assert values["detected_percent"] == pytest.approx(50.0)
    assert values["center_error_px"] == pytest.approx(0.5)
    assert values["radius_error_px"] == pytest.approx(-0.4)
    assert values["whole_radius_error_px"] == pytest.approx(-0.5)
    assert "far_radius_error_px" not in values  # of one ball


def test_no_frames_have_no_numbers():
    assert fig3.numbers([]) == {"frames": 0, "detected_percent": None, "elsewhere": 0}


def test_the_strip_is_about_the_bounce():
    answer = fig3.strip(SPEC, 0)
    times = np.array([frame["time_s"] for frame in answer["frames"]])
    bounces = [c.time for c in new_drone(STAGE, 0).truth().contacts if c.solid == "table"]
    assert answer["bounce_s"] == bounces[0]
    assert len(times) == fig3.FRAMES
    assert (times < bounces[0]).sum() == fig3.FRAMES // 2
    np.testing.assert_allclose(np.diff(times), 1.0 / 30.0, atol=1.1e-3)


def test_the_same_answers_give_the_same_json():
    found = [fig3.findings(Scale(quick=True), made()) for _ in range(2)]
    lines = [json.dumps([dict(line.values) for line in one.ours], allow_nan=False) for one in found]
    assert lines[0] == lines[1]
    assert list(found[0].figures) == ["fig3"]


def test_a_job_has_a_row_for_every_frame_that_holds_the_ball():
    rows = fig3.detections(SPEC, 1)
    assert len(rows) == len(fig3.frames_of(new_drone(STAGE, 0)))
    assert fig3.numbers(rows)["detected_percent"] > 90.0

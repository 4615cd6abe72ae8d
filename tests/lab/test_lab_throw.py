"""A serve is shown as it was played, and nothing half-made stays behind."""

import os
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image

from rotorpong.conventions import InputError
from rotorpong.geometry import rotation_from_quaternion
from rotorpong.lab import throw as thrower
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.footage import play_again
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.report import onlooker
from rotorpong.lab.report.cinema import FRAME_SIZE, Scenery, beside, onboard, shot
from rotorpong.lab.report.model import drone_faces
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.lab.throw import FILM_FPS, HELD_S, throw
from rotorpong.lab.trial import Stage, stage_of
from rotorpong.play.hover import Hover
from rotorpong.vision import PaperEyes
from rotorpong.world.court import TABLE_HALF_LENGTH, TABLE_HALF_WIDTH
from rotorpong.world.racket import HOME_BLADE, HOME_BODY, HULL, Racket
from rotorpong.world.render import Scene, render

HOVER = Spec("hover")
LEVEL = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def scenery():
    stage = Stage(HOVER, HOVER.setting(), serve_source("human", 0), "evaluate")
    return Scenery(stage, play_again(stage, 0, Hover()))


def instant(ball, trail=()):
    path = np.array([*trail, ball], dtype=float)
    return onlooker.Instant(path[-1], np.array(HOME_BODY), LEVEL, path)


def seen(ball):
    return onlooker.picture_of(instant(ball), Racket(), Scene()).astype(int)


def frames_of(path):
    film, count = cv2.VideoCapture(str(path)), 0
    while film.read()[0]:
        count += 1
    return count


def test_a_film_marks_the_trigger_of_the_player_that_is_shown():
    depths = []
    for asked in (PlayerSettings(), PlayerSettings(plane_distance=1.5)):
        spec = Spec("nearest", "truth", player_settings=asked)
        trigger = play_again(stage_of(spec.check()), 0, Hover()).trigger
        assert trigger is not None
        depths.append(trigger.position[2])
    assert 1.3 < depths[1] < 1.5 < depths[0] < 2.5


def test_what_is_shown_is_the_trial_of_the_evaluation(tmp_path):
    told = throw(HOVER, 2, tmp_path / "serve.png")
    trial = evaluate(HOVER, 3)[2]
    assert told == {
        "outcome": trial.outcome,
        "miss_distance_m": trial.miss_distance,
        "frames": 8,
        "out": str(tmp_path / "serve.png"),
    }


def test_a_randomised_serve_is_the_trial_of_the_randomised_evaluation(tmp_path):
    spec = replace(HOVER, randomize=True)
    told = throw(spec, 2, tmp_path / "serve.png")
    assert told["miss_distance_m"] == evaluate(spec, 3)[2].miss_distance
    assert told["miss_distance_m"] != throw(HOVER, 2, tmp_path / "plain.png")["miss_distance_m"]


def test_a_randomised_serve_is_shown_in_its_own_room_by_eyes_that_know_the_nominal_camera():
    spec = Spec("hover", vehicle="ardrone2", camera="ardrone2_360p", randomize=True)
    stage = Stage(spec, spec.setting(), serve_source("human", 0), "evaluate")
    take = play_again(stage, 3, Hover())
    assert take.setting.scene != stage.setting.scene
    assert take.setting.camera != stage.setting.camera
    eyes, seen = PaperEyes(stage.setting.camera), 0
    for sight in take.sights:
        nominal = eyes.see(sight.observation)
        if nominal is not None:
            assert np.array_equal(sight.estimate.position, nominal.position)
            seen += 1
    assert seen > 3
    elsewhere = replace(take, setting=stage.setting)
    rooms = [beside(Scenery(stage, taken), 0.3) for taken in (take, elsewhere)]
    assert not np.array_equal(*rooms)


def test_a_film_lasts_as_long_as_the_serve_and_its_end(tmp_path, scenery):
    told = throw(HOVER, 0, tmp_path / "serve.mp4", slow=1.0)
    expected = np.ceil(scenery.duration * FILM_FPS) + round(HELD_S * FILM_FPS)
    assert told["frames"] == frames_of(tmp_path / "serve.mp4") == expected
    assert [path.name for path in tmp_path.iterdir()] == ["serve.mp4"]


def test_an_animation_opens_with_pillow_and_has_every_frame(tmp_path):
    told = throw(HOVER, 0, tmp_path / "serve.GIF", slow=1.0)
    with Image.open(tmp_path / "serve.GIF") as animation:
        shown = sum(_ms(animation, k) for k in range(animation.n_frames))
    assert shown == pytest.approx(1000 * told["frames"] / thrower.ANIMATION_FPS, rel=0.01)


def _ms(animation, frame):
    animation.seek(frame)
    return animation.info["duration"]


@pytest.mark.parametrize(
    ("index", "name", "slow", "said"),
    [
        (-1, "a.png", 4.0, "index -1: expected a whole number from 0"),
        (0, "a.png", 0.5, "slow 0.5: expected a number from 1 to 100"),
        (0, "a.png", float("nan"), "slow nan"),
        (0, "a.avi", 4.0, "expected a name that ends with .mp4, .gif, .png"),
        (0, "a", 4.0, "expected a name that ends with .mp4"),
        (0, "gone/a.png", 4.0, "the folder .*gone does not exist"),
        (0, "folder.png", 4.0, "is a folder; expected a file"),
    ],
)
def test_what_cannot_be_written_is_refused_before_anything_is_played(
    tmp_path, index, name, slow, said
):
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(InputError, match=said):
        throw(HOVER, index, tmp_path / name, slow=slow)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_a_film_that_fails_half_way_leaves_the_old_one_alone(tmp_path):
    out = tmp_path / "serve.gif"
    out.write_text("old")

    def interrupt(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        throw(HOVER, 0, out, slow=1.0, progress=interrupt)
    assert os.listdir(tmp_path) == ["serve.gif"]
    assert out.read_text() == "old"


def test_the_onlooker_stands_upright_and_looks_at_the_target():
    axes = onlooker.gaze(onlooker.EYE, onlooker.TARGET)
    assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    middle = (onlooker.WIDTH / 2 - 0.5, onlooker.HEIGHT / 2 - 0.5)
    assert onlooker.seen_at(onlooker.TARGET) == pytest.approx(middle)
    above = onlooker.seen_at(onlooker.TARGET + np.array([0.0, 0.0, 0.1]))
    assert above[0] == pytest.approx(middle[0])
    assert above[1] < middle[1]


def test_what_is_drawn_stands_where_the_renderer_puts_it():
    """The table's corners in the onlooker's picture are where its overlay thinks they are."""
    bare = Scene(opponent=False, texture_contrast=0.0, ball_shadow=0.0)
    nowhere = np.array([0.0, 0.0, 30.0])
    picture = render(onlooker.ONLOOKER, onlooker.EYE, onlooker.AXES, nowhere, bare).astype(int)
    inside = np.array([-TABLE_HALF_LENGTH + 0.06, -TABLE_HALF_WIDTH + 0.06, 0.0])
    for outward in ([-0.08, 0.0, 0.0], [0.0, -0.08, 0.0]):
        x, y = np.rint(onlooker.seen_at(inside)).astype(int)
        u, v = np.rint(onlooker.seen_at(inside + np.array(outward))).astype(int)
        assert np.abs(picture[y, x] - np.array(bare.table)).max() < 40
        assert np.abs(picture[v, u] - np.array(bare.table)).max() > 40


def test_the_drone_is_drawn_as_large_as_what_the_ball_can_touch():
    points = np.concatenate([face.points for face in drone_faces(Racket())])
    blade = points[np.abs(points[:, 0] - Racket().x) < 1e-9]
    assert blade[:, 1].max() == pytest.approx(Racket().half_width, rel=0.01)
    assert blade[:, 2].max() == pytest.approx(Racket().z + Racket().half_height, rel=0.01)
    hull = points[np.abs(points[:, 2]) < HULL.half_height]
    assert np.hypot(hull[:, 0], hull[:, 1]).max() == pytest.approx(HULL.radius, rel=0.03)


def test_the_blade_hides_a_ball_behind_it_and_not_one_before_it():
    along = np.array(HOME_BLADE) - onlooker.EYE
    along /= np.linalg.norm(along)
    away = seen([2.0, 3.0, 2.0])
    x, y = np.rint(onlooker.seen_at(np.array(HOME_BLADE))).astype(int)
    behind = seen(np.array(HOME_BLADE) + 0.3 * along)
    before = seen(np.array(HOME_BLADE) - 0.3 * along)
    assert np.abs(behind[y, x] - away[y, x]).max() <= 2
    assert before[y, x, 2] - before[y, x, 0] > 60 + away[y, x, 2] - away[y, x, 0]


def test_the_attitude_of_the_truth_carries_the_blade(scenery):
    truth, racket = scenery.take.played.truth, Racket()
    lever = rotation_from_quaternion(truth.attitude_path) @ [racket.x, racket.y, racket.z]
    assert truth.body_path + lever == pytest.approx(truth.blade_path, abs=1e-12)


def test_a_shot_shows_the_frame_itself_beside_the_onlookers_view(scenery):
    picture = shot(scenery, 0.3)
    assert picture.shape == (FRAME_SIZE[1], FRAME_SIZE[0], 3)
    sights = [s for s in scenery.take.sights if s.observation.frame_time <= 0.3]
    frame, panel = sights[-1].observation.frame.picture, onboard(scenery, 0.3)
    changed = np.any(panel != frame, axis=2).mean()
    assert 0.0 < changed < 0.01  # the circle, and nothing else
    assert not np.array_equal(shot(scenery, 0.3), shot(scenery, 0.3, ended=True))

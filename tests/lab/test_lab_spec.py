"""Everything unknown is refused at the door, and a user's own player is taken in."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from rotorpong.conventions import LARGEST_SEED, InputError
from rotorpong.drone import Player
from rotorpong.lab.eye_settings import EyeSettings
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec, camera_named, own_player, require_count
from rotorpong.lab.trial import meet, new_drone, stage_of
from rotorpong.physics.ball import Air
from rotorpong.physics.camera import GAZEBO
from rotorpong.physics.vehicle import TUM_GAZEBO
from rotorpong.vision.colour import COLOURS, ORANGE, Colour
from rotorpong.vision.colour_files import colour_text
from rotorpong.world.looks import BALLS
from rotorpong.world.render import Scene
from rotorpong.world.serves import HUMAN, Medium, ServeKind

OWN = """
class Own:
    def play(self, drone, eyes, rng):
        while drone.observe() is not None:
            pass

    def learn(self, verdict):
        pass
"""


def _thrown(spec, index):
    stage = stage_of(spec)
    generators = trial_generators(spec.seed, stage.purpose, index)
    return meet(stage, index, generators)[0]


def test_the_default_can_be_played():
    assert Spec().check() == Spec()


def test_a_spec_travels_to_a_worker():
    spec = Spec("hover", serves="constant", seed=4, vehicle=TUM_GAZEBO, camera=GAZEBO)
    assert pickle.loads(pickle.dumps(spec)) == spec


def test_vehicle_and_camera_are_names_or_objects():
    named, passed = Spec(), Spec(vehicle=TUM_GAZEBO, camera=replace(GAZEBO, name="mine"))
    assert named.setting().vehicle is passed.setting().vehicle
    assert (passed.vehicle_name, passed.camera_name) == ("tum_gazebo", "mine")
    assert passed.check().camera_profile().name == "mine"


def test_a_kind_of_serve_is_a_name_or_an_object():
    middle = ServeKind("middle", target_left=(0.1, 0.1), target_up=(0.05, 0.05))
    spec = Spec("hover", serves=middle).check()
    targets = {_thrown(spec, index).target for index in range(3)}
    assert (spec.serves_name, targets) == ("middle", {(0.1, 0.05)})
    human = Spec("hover", serves=replace(HUMAN))
    thrown = [_thrown(spec, 5).ball.velocity for spec in (human, Spec("hover"))]
    np.testing.assert_array_equal(*thrown)


def test_a_kind_of_ones_own_is_known_by_what_it_is_not_by_its_name():
    narrow = ServeKind("mine", target_left=(-0.2, 0.2))
    digests = [
        Spec(serves=kind).contents().get("serves")
        for kind in (narrow, replace(narrow, name="other"), replace(narrow, spin_sd=1.0), HUMAN)
    ]
    assert digests[0] == digests[1] != digests[2]
    assert digests[3] is None


def test_a_kind_of_ones_own_flies_through_its_own_air():
    moon = ServeKind("moon", medium=Medium(air=Air(drag=0.0)))
    assert _thrown(Spec("hover", serves=moon), 0).air.drag == 0.0


@pytest.mark.parametrize(
    ("field", "given", "message"),
    [
        (
            "player",
            "nobody",
            "unknown player 'nobody': expected one of hover, nearest, single, paper,",
        ),
        ("player", "", "unknown player ''"),
        ("player", "own.py", "unknown player 'own.py'"),
        ("player", "gone.py:Own", "no file 'gone.py'; expected FILE.py:CLASS"),
        ("eyes", "radar", "unknown eyes 'radar': expected one of truth, paper, tracker"),
        ("vehicle", "crazyflie", "unknown vehicle 'crazyflie': expected one of tum_gazebo"),
        ("camera", "nikon", "camera 'nikon': expected one of gazebo, ardrone2_360p"),
        ("camera", "", "camera '': expected one of gazebo"),
        ("serves", "smash", "serves 'smash': expected one of human, constant, hard, lob"),
        ("serves", "", "serves '': expected one of human"),
        ("racket", "wood", "unknown racket 'wood': expected one of cardboard, rubber"),
        ("seed", -1, "seed -1: expected a whole number from 0 to 9223372036854775807"),
        ("seed", LARGEST_SEED + 1, "seed 9223372036854775808: expected a whole number"),
    ],
)
def test_what_is_unknown_is_refused_with_what_is_known(field, given, message):
    with pytest.raises(InputError) as refusal:
        replace(Spec(), **{field: given}).check()
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_eyes_that_look_at_no_frame_cannot_be_blacked_out():
    with pytest.raises(InputError, match="blackout with eyes truth"):
        Spec(eyes="truth", blackout=True).check()
    assert Spec(eyes="paper", blackout=True).check()


@pytest.mark.parametrize("count", [0, -1, 10_000_001, 10**30])
def test_counts_have_bounds(count):
    with pytest.raises(InputError, match=f"balls {count}: expected a whole number from 1 to"):
        require_count("balls", count)


def test_a_calibration_file_is_a_camera(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text('{"fx": 500, "fy": 500, "cx": 320, "cy": 180, "width": 640, "height": 360}')
    assert camera_named(str(path)).focal_length_px == (500.0, 500.0)
    assert Spec(camera=str(path)).check().camera_name == str(path)
    path.write_text('{"fx": NaN, "fy": 500, "cx": 320, "cy": 180, "width": 640, "height": 360}')
    with pytest.raises(InputError, match=r"mine\.json: fx is 'nan'; expected a finite number"):
        Spec(camera=str(path)).check()


def test_a_folder_is_no_camera(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        camera_named(str(tmp_path))


def own(folder, text, name="own.py"):
    path = folder / name
    path.write_text(text)
    return path


def test_a_users_own_player_is_loaded_from_its_file(tmp_path):
    name = f"{own(tmp_path, OWN)}:Own"
    make = own_player(name)
    one, two = make(), make()
    assert isinstance(one, Player)
    assert one is not two
    assert Spec(name).check().is_own_player


def test_a_users_own_player_may_be_a_dataclass_with_postponed_annotations(tmp_path):
    text = "from __future__ import annotations\nimport dataclasses\n@dataclasses.dataclass\n"
    text += OWN.strip().replace("class Own:", "class Own:\n    speed: float = 1.0")
    assert own_player(f"{own(tmp_path, text, 'postponed.py')}:Own")().speed == 1.0


@pytest.mark.parametrize(
    ("text", "name", "said"),
    [
        ("class Own(:\n", "Own", "SyntaxError"),
        (OWN, "Other", "no attribute 'Other'"),
        (OWN, "", "no attribute ''"),
        ("1 / 0\n", "Own", "ZeroDivisionError: division by zero"),
        ("import sys\nsys.exit(3)\n", "Own", "SystemExit: 3"),
        ("import nothing_of_that_name\n", "Own", "ModuleNotFoundError"),
        ("Own = 3\n", "Own", "'int' object is not callable"),
        ("class Own:\n    def play(self, drone, eyes, rng): ...\n", "Own", "expected a class with"),
        ("class Own:\n    def __init__(self, x): ...\n", "Own", "missing 1 required positional"),
        ("class Own:\n    def __init__(self): exit()\n", "Own", "SystemExit"),
    ],
)
def test_a_file_that_holds_no_player_is_refused(tmp_path, text, name, said):
    path = own(tmp_path, text)
    with pytest.raises(InputError, match=f"player '{path}:{name}'") as refusal:
        Spec(f"{path}:{name}").check()
    assert said in str(refusal.value)


def test_a_class_that_can_be_made_only_once_is_refused_later(tmp_path):
    text = (
        OWN
        + "\n    made = []\n    def __init__(self):\n        Own.made.append(1 // (not Own.made))"
    )
    make = own_player(f"{own(tmp_path, text)}:Own")
    with pytest.raises(InputError, match="ZeroDivisionError"):
        make()


def test_human_serves_depend_on_the_generator_alone():
    one, two = (serve_source("human", seed)(0, np.random.default_rng(1)) for seed in (0, 9))
    np.testing.assert_array_equal(one.ball.velocity, two.ball.velocity)


def test_constant_serves_scatter_about_one_that_the_seed_draws():
    def velocities(seed):
        source = serve_source("constant", seed)
        return np.array([
            source(i, np.random.default_rng(i)).ball.velocity for i in range(12)
        ])  # fmt: skip

    one, again, other = velocities(0), velocities(0), velocities(1)
    np.testing.assert_array_equal(one, again)
    speeds = np.linalg.norm(one, axis=1)
    assert 0.05 < speeds.std() < 0.5  # 0.2 m/s
    assert not np.allclose(one, other)
    releases = [
        serve_source("constant", 0)(i, np.random.default_rng(i)).ball.position for i in (0, 1)
    ]
    np.testing.assert_array_equal(*releases)


def test_rows_of_a_file_are_thrown_in_turn(tmp_path):
    from rotorpong.lab.serve_files import write_serves

    source = serve_source("human", 0)
    serves = [source(i, np.random.default_rng(i)) for i in range(3)]
    write_serves(tmp_path / "serves.csv", serves)
    thrown = serve_source(str(tmp_path / "serves.csv"), 0)
    for i in range(7):
        found = thrown(i, np.random.default_rng(99))
        np.testing.assert_array_equal(found.ball.velocity, serves[i % 3].ball.velocity)


GREEN = Colour("green", (50, 120, 100), (45, 90, 60), (75, 255, 255), (60, 180, 160))


@pytest.fixture
def green(tmp_path):
    path = tmp_path / "green.json"
    path.write_text(colour_text(GREEN))
    return str(path)


@pytest.mark.parametrize(
    ("eyes", "given", "message"),
    [
        ("truth", {"circle_fit": "kasa"}, "--circle-fit kasa with eyes 'truth': has no effect"),
        ("truth", {"colour": "orange"}, "expected eyes paper or tracker"),
        ("tracker", {"circle_fit": "pratt"}, "has no effect; expected eyes paper"),
        ("tracker", {"diameter": "whole"}, "--diameter whole with eyes 'tracker'"),
        ("paper", {"circle_fit": "ransac"}, "unknown circle fit 'ransac': expected one of kasa,"),
        ("paper", {"diameter": "half"}, "unknown diameter 'half': expected one of whole, float"),
        ("paper", {"colour": "pink"}, "unknown colour 'pink': expected one of orange, white, or a"),
        ("paper", {"colour": ""}, "unknown colour ''"),
    ],
)
def test_settings_that_are_unknown_or_without_effect_are_refused(eyes, given, message):
    with pytest.raises(InputError) as refusal:
        Spec(eyes=eyes, eye_settings=EyeSettings(**given)).check()
    assert message in str(refusal.value)


def test_balls_are_orange_or_white():
    assert Spec(ball="white").check().setting().scene.ball == BALLS["white"]
    assert Spec().setting().scene == Scene()
    with pytest.raises(InputError, match="unknown ball 'green': expected one of orange, white"):
        Spec(ball="green").check()


def test_eyes_look_for_the_ball_that_is_thrown_unless_told_otherwise(green):
    assert Spec().colour() == COLOURS["orange"]
    assert Spec(ball="white").colour() == COLOURS["white"]
    assert Spec(ball="white", eye_settings=EyeSettings(colour="orange")).colour() == ORANGE
    assert Spec(eye_settings=EyeSettings(colour=green)).check().colour() == GREEN


def test_both_eyes_find_a_ball_of_a_colour_from_a_file(green):
    """A green ball is thrown: eyes that are told so place it."""
    for eyes, error in (("paper", 0.3), ("tracker", 0.05)):
        told = Spec(eyes=eyes, eye_settings=EyeSettings(colour=green)).check()
        stage = stage_of(told)
        scene = replace(stage.setting.scene, ball=(60, 170, 50))
        drone = new_drone(replace(stage, setting=replace(stage.setting, scene=scene)), 3)
        seeing, errors = told.make_eyes(drone), []
        while (seen := drone.observe()) is not None:
            truth, _ = drone.ball_in_camera(seen.frame_time)
            if (estimate := seeing.see(seen)) is not None and truth[2] > 0.5:
                errors.append(np.linalg.norm(estimate.position - truth) / truth[2])
        assert len(errors) > 10
        assert np.median(errors) < error


def test_what_a_colour_file_holds_counts_and_not_its_name(green, tmp_path):
    first = Spec(eye_settings=EyeSettings(colour=green)).contents()
    other = tmp_path / "other.json"
    other.write_text(colour_text(replace(GREEN, name="renamed")))
    assert Spec(eye_settings=EyeSettings(colour=str(other))).contents() == first
    other.write_text(colour_text(replace(GREEN, typical=(61, 180, 160))))
    assert Spec(eye_settings=EyeSettings(colour=str(other))).contents() != first
    other.write_text(colour_text(replace(ORANGE, name="mine")))
    assert Spec(eye_settings=EyeSettings(colour=str(other))).contents() == {}


def test_the_settings_are_told_as_they_are():
    asked = EyeSettings("pratt", "float", "white")
    assert asked.as_json("paper", "orange") == {
        "colour": "white",
        "circle_fit": "pratt",
        "diameter": "float",
    }
    told = EyeSettings().as_json("paper", "white")
    assert told == {"colour": "white", "circle_fit": "kasa", "diameter": "whole"}
    assert EyeSettings().as_json("tracker", "orange") == {"colour": "orange"}
    assert EyeSettings().as_json("truth", "orange") == {}
    assert EyeSettings("kasa", "whole", "orange").unusual("paper", "orange") == {}
    assert asked.unusual("paper", "orange") == asked.as_json("paper", "orange")

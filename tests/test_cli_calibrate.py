"""`rotorpong calibrate`: what it writes, `--camera` and `--colour` take; bad input is told."""

import json
import shutil

import cv2
import numpy as np
import pytest
from calibration_scenes import ROTATIONS, ball_scene, write_balls, write_boards
from test_cli import ask, complaint, is_one_line_of_json

from rotorpong.lab.spec import camera_named
from rotorpong.physics.camera import ARDRONE2_360P
from rotorpong.vision.calibration import read_camera
from rotorpong.vision.colour_files import read_colour

GREEN = (60, 190, 70)  # blue, green, red
GREY = (110, 100, 90)
COLOUR = '{"name": "own", "core": [50, 120, 100], "lower": [45, 90, 60], "upper": [75, 255, 255], '
COLOUR += '"typical": [60, 180, 160]}'


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folders of boards and balls, drawn once."""
    folder = tmp_path_factory.mktemp("made")
    write_boards(folder / "boards")
    write_boards(folder / "parallel", 6, rotations=[(0.0, 0.0, 0.0)] * 6)
    write_boards(folder / "two", 2)
    write_boards(folder / "sizes", 1)
    cv2.imwrite(str(folder / "sizes" / "large.png"), np.zeros((720, 1280, 3), np.uint8))
    write_balls(folder / "green", GREEN)
    write_balls(folder / "grey", GREY, background=GREY)
    write_balls(folder / "red", (30, 30, 220))
    return folder


@pytest.fixture
def there(made, tmp_path, monkeypatch):
    """A folder with what `made` holds, and things that are not what they should be."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    for name in ("empty", "texts", "damaged"):
        (tmp_path / name).mkdir()
    (tmp_path / "text").write_text("hello")
    (tmp_path / "texts" / "notes.txt").write_text("hello")
    (tmp_path / "nothing").touch()
    (tmp_path / "damaged" / "a.png").write_bytes(b"\x89PNG")
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "odd.json").write_text(COLOUR.replace("typical", "typcal"))
    (tmp_path / "wide.json").write_text(COLOUR.replace("255, 255", "256, 255"))
    (tmp_path / "own.json").write_text(COLOUR)
    (tmp_path / "named_orange.json").write_text(COLOUR.replace("own", "orange"))
    shutil.copy(tmp_path / "green" / "0.png", tmp_path / "ball.png")
    rows = {
        "header": "",
        "columns": "ball.png,1,2,30",
        "outside": "ball.png,300,10,340,40",
        "negative": "ball.png,-1,10,20,40",
        "reversed": "ball.png,40,10,20,40",
        "flat": "ball.png,10,10,40,10",
        "nan": "ball.png,nan,10,40,40",
        "gone": "gone.png,10,10,40,40",
        "undecodable": "damaged/a.png,10,10,40,40",
        "unnamed": ",10,10,40,40",
        "full": "ball.png,0,0,320,240",
    }
    for name, row in rows.items():
        (tmp_path / f"{name}.csv").write_text(f"picture,x0,y0,x1,y1\n{row}\n")
    (tmp_path / "other.csv").write_text("picture,left,top,x1,y1\nball.png,1,2,30,40\n")
    return tmp_path


CAMERA = "calibrate camera {} --out new.json"
COLOURS = "calibrate colour {} --out new.json"
BAD = {
    "calibrate": "camera, colour",
    "calibrate lens": "Available subcommands: camera, colour",
    "calibrate camera boards": "--out PATH",
    CAMERA.format("gone"): "gone: no such folder; expected a folder of chessboard pictures",
    CAMERA.format("text"): "text: is no folder",
    CAMERA.format("empty"): "folder empty holds no picture, 0 other entries; expected chessboard",
    CAMERA.format("texts"): "folder texts holds no picture, 1 other entries",
    CAMERA.format("damaged"): "damaged: 0 pictures show a whole board of 9 x 6 inner corners, "
    "0 none, 1 cannot be read; expected at least 3",
    CAMERA.format("two"): "two: 2 pictures show a whole board of 9 x 6 inner corners, 0 none",
    CAMERA.format("green"): "green: 0 pictures show a whole board of 9 x 6 inner corners, 3 none",
    CAMERA.format("sizes"): "large.png: 1280 x 720 pixels, where those before have 640 x 360",
    CAMERA.format("parallel"): "parallel within",
    CAMERA.format("boards --board 9"): "board '9'; expected its inner corners as COLUMNSxROWS",
    CAMERA.format("boards --board 2x6"): "board '2x6'; expected",
    CAMERA.format("boards --board 9x600"): "board '9x600'; expected",
    CAMERA.format("boards --board -9x6"): "board",
    CAMERA.format("boards --square-mm 0"): "square 0 mm; expected above 0",
    CAMERA.format("boards --square-mm nan"): "square nan mm; expected above 0",
    CAMERA.format("boards --frames-per-second 0"): "frames per second 0.0; expected 1 to 1000",
    "calibrate camera boards --out new.txt": "expected a name that ends in .json, .yaml, .yml",
    "calibrate camera boards --out gone/new.json": "the folder gone does not exist",
    "calibrate colour green/boxes.csv": "--out PATH",
    COLOURS.format("gone.csv.csv"): "gone.csv.csv: no such file",
    COLOURS.format("empty"): "empty: no such file",
    COLOURS.format("nothing"): "nothing: is empty; expected the columns picture,x0,y0,x1,y1",
    COLOURS.format("text"): "text: lacks picture, x0, y0, x1, y1; it begins with 'hello'",
    COLOURS.format("other.csv"): "other.csv: lacks x0, y0; it begins with 'picture,left,top",
    COLOURS.format("header.csv"): "header.csv: 0 boxes; expected 1 to 10000",
    COLOURS.format("columns.csv"): "columns.csv: line 2: expected picture,x0,y0,x1,y1",
    COLOURS.format("outside.csv"): "line 2: a box from (300, 10) to (340, 40) in a picture of "
    "320 x 240 pixels; expected one within it",
    COLOURS.format("negative.csv"): "a box from (-1, 10) to (20, 40) in a picture",
    COLOURS.format("reversed.csv"): "a box from (40, 10) to (20, 40); expected x0 < x1",
    COLOURS.format("flat.csv"): "a box from (10, 10) to (40, 10); expected x0 < x1",
    COLOURS.format("nan.csv"): "nan.csv: line 2: 'nan'; expected a finite number",
    COLOURS.format("gone.csv"): "gone.csv: line 2: gone.png: no such picture",
    COLOURS.format("undecodable.csv"): "a.png: not a picture that OpenCV can decode, or damaged",
    COLOURS.format("unnamed.csv"): "expected picture,x0,y0,x1,y1, with a picture's name",
    COLOURS.format("full.csv"): "full.csv: boxes fill their pictures",
    COLOURS.format("grey/boxes.csv"): "no colour tells these balls from what is around them",
    COLOURS.format("red/boxes.csv"): "go over red's 0 = 180, which limits of a colour cannot",
    COLOURS.format("green/boxes.csv --name a,b"): "name 'a,b'; expected 1 to 40 printable",
    "calibrate colour green/boxes.csv --out new.yaml": "expected a name that ends in .json",
    "detect ball.png --colour gone.json": "unknown colour 'gone.json': expected one of orange, "
    "white, or a file of `calibrate colour`",
    "detect ball.png --colour broken.json": "colour broken.json: is no JSON; expected an object",
    "detect ball.png --colour odd.json": "odd.json: unknown typcal; lacks typical; expected name",
    "detect ball.png --colour wide.json": "upper is [75, 256, 255]; expected whole numbers",
    "detect ball.png --colour empty": "colour empty: cannot be read",
    "detect ball.png --colour ball.png": "ball.png: is larger than 65536 bytes; expected",
    "detect ball.png --colour orange,named_orange.json": "2 of them are named 'orange'",
}


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line_that_says_what_was_expected(there, capfd, line):
    assert BAD[line] in complaint(capfd, line, there)


@pytest.mark.parametrize("name", ["own.json", "own.yaml", "own.YML"])
def test_a_calibrated_camera_is_the_one_that_took_the_pictures(there, capfd, name):
    shutil.copy(there / "ball.png", there / "boards" / "z.png")
    cv2.imwrite(str(there / "boards" / "z.png"), np.full((360, 640, 3), 90, np.uint8))
    (there / "boards" / "y.jpg").write_bytes(b"\xff\xd8\xff")
    line = f"calibrate camera boards --out {name} --frames-per-second 15 --json"
    status, out, err = ask(capfd, *line.split())
    assert (status, err) == (0, "")
    assert is_one_line_of_json(out)
    told = json.loads(out)
    assert len(told["pictures_used"]) == len(ROTATIONS)
    assert (told["pictures_without_board"], told["pictures_unreadable"]) == (["z.png"], ["y.jpg"])
    assert told["reprojection_rms_px"] < 0.3
    wanted = ARDRONE2_360P.focal_length_px
    np.testing.assert_allclose(told["focal_length_px"], wanted, rtol=0.005)
    np.testing.assert_allclose(told["center_px"], ARDRONE2_360P.center_px, atol=3.0)
    camera = read_camera(there / name)
    assert camera.name == told["name"] == "own"
    assert list(camera.focal_length_px) == told["focal_length_px"]
    assert list(camera.center_px) == told["center_px"]
    assert list(camera.distortion) == told["distortion"]
    assert (camera.width_px, camera.height_px, camera.frames_per_second) == (640, 360, 15.0)
    assert camera_named(name) == camera


def test_opencv_reads_the_yaml_too(there, capfd):
    ask(capfd, *["calibrate", "camera", "boards", "--out", "own.yaml"])
    storage = cv2.FileStorage("own.yaml", cv2.FILE_STORAGE_READ)
    assert storage.getNode("image_width").real() == 640.0
    assert storage.getNode("camera_name").string() == "own"


def boxes_of(folder):
    rows = (folder / "boxes.csv").read_text().splitlines()[1:]
    return [row.split(",") for row in rows]


def test_a_learnt_colour_finds_balls_that_the_default_misses(there, capfd):
    line = "calibrate colour green/boxes.csv --out green.json --json"
    status, out, err = ask(capfd, *line.split())
    assert (status, err) == (0, "")
    assert is_one_line_of_json(out)
    told = json.loads(out)
    assert (told["balls"], told["balls_found"], told["pictures"]) == (9, 9, 3)
    assert told["recall"] > 0.95
    assert told["background_pixels_taken"] < 0.01 * told["background_pixels"]
    colour = read_colour(there / "green.json")
    assert [told[key] for key in ("name", "core", "lower", "upper", "typical")] == [
        colour.name, *map(list, (colour.core, colour.lower, colour.upper, colour.typical))
    ]  # fmt: skip
    picture, boxes = ball_scene(np.random.default_rng(77), GREEN)  # never seen before
    cv2.imwrite(str(there / "new.png"), picture)
    for given, found in (("orange", 0), ("green.json", 3), ("orange,green.json", 3)):
        status, out, _ = ask(capfd, "detect", "new.png", "--colour", given, "--json")
        assert status == 0
        balls = json.loads(out)["pictures"][0]["balls"]
        assert len(balls) == found
    for left, top, right, bottom in boxes:
        near = [b for b in balls if left < b["x_px"] < right and top < b["y_px"] < bottom]
        assert len(near) == 1
        assert near[0]["colour"] == "green"
        assert near[0]["diameter_px"] == pytest.approx(right - left - 1.5, abs=2.0)


def test_pictures_are_looked_for_from_the_csvs_folder_and_columns_may_be_in_any_order(there, capfd):
    rows = ["y1,x1,note,y0,x0,picture"]
    rows += [
        ",".join((y1, x1, "seen", y0, x0, p)) for p, x0, y0, x1, y1 in boxes_of(there / "green")
    ]
    (there / "green" / "other.csv").write_text("\r\n".join(rows) + "\r\n")
    learnt = []
    for name in ("boxes", "other"):
        line = f"calibrate colour green/{name}.csv --out a.json --name leaf"
        assert ask(capfd, *line.split())[0] == 0
        learnt.append(read_colour(there / "a.json"))
    assert learnt[0] == learnt[1]
    assert learnt[0].name == "leaf"


def test_without_json_a_table_is_shown(there, capfd):
    for line, shown in (
        ("calibrate camera boards --out a.json", "reprojection error"),
        ("calibrate colour green/boxes.csv --out b.json", "balls found with it"),
    ):
        status, out, err = ask(capfd, *line.split())
        assert (status, err) == (0, "")
        assert shown in out


def test_what_was_there_stays_when_nothing_is_learnt(there, capfd):
    before = (there / "own.json").read_bytes()
    for line in ("camera two", "colour grey/boxes.csv"):
        assert ask(capfd, "calibrate", *line.split(), "--out", "own.json")[0] == 2
    assert (there / "own.json").read_bytes() == before

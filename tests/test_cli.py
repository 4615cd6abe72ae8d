"""The command line, met by a hostile user: one line, status 2, and never a traceback."""

import json
import os
import signal
import subprocess
import sys
import time

import cv2
import numpy as np
import pytest

import rotorpong
from rotorpong.cli import entry as cli
from rotorpong.conventions import InputError

PLAYER = """
class Own:
    def play(self, drone, eyes, rng):
        {}

    def learn(self, verdict):
        pass
"""
SERVE_HEADER = "x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s,"
SERVE_HEADER += "drag_per_m,restitution,friction\n"
TRAIN = "train --hits 1 --seed 1 --eyes truth"  # seed 1: the first ball is hit
HEAVY = ("gymnasium", "jaxtyping", "numpy", "numba", "cv2", "scipy", "matplotlib", "rich")


def ask(capsys, *arguments):
    """Run a command in this process; return its status, stdout and stderr."""
    capsys.readouterr()
    try:
        status = cli._run([str(argument) for argument in arguments])
    except SystemExit as left:
        status = left.code
    said = capsys.readouterr()
    return status, said.out, said.err


def shell(*arguments, **options):
    """Start the command as a user would."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    command = [sys.executable, "-m", "rotorpong", *arguments]
    return subprocess.Popen(command, **{**pipes, **options})


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder full of things that are not what they should be."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "text").write_text("hello")
    (tmp_path / "nothing").touch()
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "nan.csv").write_text(SERVE_HEADER + "2,0,0.3,-7,0,nan,0,0,0,0.15,0.88,0.25\n")
    rows = [f"{0.01 * i},{2 - 0.05 * i},0,{'nan' if i == 7 else 0.3}\n" for i in range(40)]
    (tmp_path / "flight.csv").write_text("time_s,x_m,y_m,z_m\n" + "".join(rows))
    (tmp_path / "damaged.json").write_text("{")
    (tmp_path / "damaged.sqlite").write_bytes(b"SQLite format 3\0" + bytes(500))
    (tmp_path / "syntax.py").write_text("class Own(:\n")
    (tmp_path / "ball.png").write_bytes(cv2.imencode(".png", ball_picture())[1].tobytes())
    whole = (tmp_path / "ball.png").read_bytes()
    (tmp_path / "truncated.png").write_bytes(whole[: len(whole) // 2])
    return tmp_path


def ball_picture():
    picture = np.full((360, 640, 3), 120, np.uint8)
    return cv2.circle(picture, (300, 180), 12, (0, 120, 255), -1, cv2.LINE_AA)


BAD = {
    "evaluate --balls 0": "balls 0: expected a whole number from 1 to 10000000",
    "evaluate --balls -1": "balls -1: expected a whole number",
    "evaluate --balls 99999999999999999999": "expected a whole number from 1 to 10000000",
    "evaluate --balls 1.5": "--balls: invalid literal for int() with base 10: '1.5'",
    "evaluate --balls many": "--balls: invalid literal for int() with base 10: 'many'",
    "evaluate --balls": "Missing value for argument '--balls'",
    "evaluate --workers 0": "workers 0: expected a whole number",
    "evaluate --workers -3": "workers -3: expected a whole number",
    "evaluate --seed -1": "seed -1: expected a whole number from 0 to 9223372036854775807",
    "evaluate --seed 99999999999999999999": "seed 99999999999999999999: expected",
    "evaluate --seed zero": "--seed: invalid literal for int()",
    "evaluate --player nobody": "hover, nearest, single, paper, bandit, oracle, or your own",
    "evaluate --player gone.py:Own": "no file 'gone.py'; expected FILE.py:CLASS",
    "evaluate --player syntax.py:Own": "SyntaxError",
    "evaluate --player empty:Own": "unknown player 'empty:Own'",
    "evaluate --eyes radar": "unknown eyes 'radar': expected one of truth, paper, tracker",
    "bench eyes --flights .": "--flights with bench eyes: belongs to bench world",
    "evaluate --vehicle crazyflie": "unknown vehicle 'crazyflie': expected one of tum_gazebo",
    "evaluate --camera nikon": "camera 'nikon': expected one of gazebo, ardrone2_360p",
    "evaluate --camera damaged.json": "calibration damaged.json: is damaged JSON",
    "evaluate --camera empty": "calibration empty: cannot be read",
    "evaluate --serves smash": "serves 'smash': expected one of human, constant, hard, lob",
    "evaluate --serves nan.csv": "nan.csv: line 2: 'nan'; expected a finite number",
    "evaluate --serves flight.csv": "flight.csv: line 9: 'nan'; expected a finite number",
    "evaluate --serves nothing": "nothing: is empty",
    "evaluate --serves text": "begins with 'hello'",
    "evaluate --serves binary.csv": "binary.csv: no UTF-8 text",
    "evaluate --serves empty": "empty: 0 files, none of them a flight",
    "evaluate --racket wood": "unknown racket 'wood': expected one of cardboard, rubber",
    "evaluate --eyes truth --blackout": "--blackout with eyes truth",
    "evaluate --experience gone.sqlite": "gone.sqlite: does not exist",
    "evaluate --experience damaged.sqlite": "damaged.sqlite: not an experience file",
    "evaluate --experience nothing": "nothing: not an experience file",
    "evaluate --experience text": "text: not an experience file",
    "evaluate --experience empty": "empty: is a folder; expected an experience file",
    "evaluate --nonsense": "Unrecognized options: --nonsense",
    "evaluate --nonsense 3": "Unrecognized options: --nonsense",
    "evaluate extra": "Unrecognized options: extra",
    "train": "Missing from rotorpong train: --hits",
    "train --hits 1": "--out PATH",
    "train --hits 0 --out run": "hits 0: expected a whole number",
    "train --hits -1 --out run": "hits -1: expected a whole number",
    "train --hits 1 --out run --player hover": "cannot learn: expected one of single,",
    "train --hits 1 --out run --seed -1": "seed -1: expected",
    "train --hits 1 --out run --serves nan.csv": "nan.csv: line 2: 'nan'",
    "train --hits 1 --out empty --eyes truth": "empty: is a folder; expected a file",
    "train --hits 1 --out gone/run --eyes truth": "the folder gone does not exist",
    "train --hits 1 --out text --eyes truth": "text: exists; use --resume",
    "train --hits 1 --out damaged.sqlite --resume --eyes truth": "not an experience file",
    "detect": "no path given; expected pictures, folders or videos",
    "detect gone.png": "gone.png: no such file or folder",
    "detect empty": "folder empty holds no readable picture or video",
    "detect nothing": "nothing: not a picture that OpenCV can decode, or damaged",
    "detect truncated.png": "truncated.png: not a picture that OpenCV can decode, or damaged",
    "detect nan.csv": "nan.csv: not a picture",
    "detect ball.png --min-score 2": "minimum score 2.0; expected 0 to 1",
    "detect ball.png --min-score nan": "minimum score nan",
    "detect ball.png --min-score high": "--min-score: could not convert string to float: 'high'",
    "detect ball.png --ball-diameter-mm 0": "ball diameter 0 mm: expected above 0 and below 1000",
    "detect ball.png --ball-diameter-mm -4": "ball diameter -4 mm",
    "detect ball.png --ball-diameter-mm 40000": "ball diameter 40000 mm",
    "detect ball.png --colour pink": "unknown colour 'pink': expected one of orange, white",
    "detect ball.png --colour orange,": "unknown colour ''",
    "detect ball.png --eyes truth": "unknown eyes 'truth': expected one of paper, tracker",
    "detect ball.png --camera nikon": "camera 'nikon': expected one of gazebo, ardrone2_360p",
    "detect ball.png --camera ardrone2_720p": "is calibrated for 1280 x 720",
    "detect ball.png --out text": "out 'text' is a file: expected a folder",
    "detect ball.png --out film.mp4": "out 'film.mp4' is one film: expected one video",
    "detect ball.png --eyes tracker --circle-fit pratt": "--circle-fit pratt with eyes 'tracker'",
    "detect ball.png --circle-fit ransac": "unknown circle fit 'ransac': expected one of kasa, pr",
    "detect ball.png --diameter half": "unknown diameter 'half': expected one of whole, float",
    "evaluate --trigger time": "unknown trigger 'time': expected one of plane, distance",
    "evaluate --plane-distance-m 0": "--plane-distance-m 0.0: expected a number from 0.8 to 4 m",
    "evaluate --plane-distance-m nan": "--plane-distance-m nan: expected a number from 0.8 to 4",
    "evaluate --player bandit --exploration-sd-m 0.2": "with player 'bandit': has no effect",
    "evaluate --exploration-sd-m -1": "--exploration-sd-m -1.0: expected a number from 0 to 1 m",
    "evaluate --selection best": "unknown selection 'best': expected one of paper, temperature",
    "evaluate --player single --selection ucb": "--selection ucb with player 'single': has no ef",
    "evaluate --temperature 0.1": "--temperature 0.1: has no effect without --selection temp",
    "evaluate --selection ucb --deviations -1": "--deviations -1.0: expected a number from 0 to",
    "evaluate --player hover --learn-from-misses": "--learn-from-misses with player 'hover': has",
    "evaluate --control loose": "unknown control 'loose': expected one of open, feed-forward, cl",
    "evaluate --player hover --control open": "--control open with player 'hover': has no effect",
    "throw --out a.gif --player oracle --eyes truth --control open": "expected player nearest or",
    "evaluate --ball green": "unknown ball 'green': expected one of orange, white",
    "evaluate --circle-fit ransac": "unknown circle fit 'ransac': expected one of kasa, pratt",
    "evaluate --diameter half": "unknown diameter 'half': expected one of whole, float",
    "evaluate --eyes truth --diameter float": "--diameter float with eyes 'truth': has no effect",
    "evaluate --eyes tracker --circle-fit kasa": "--circle-fit kasa with eyes 'tracker': has no",
    "evaluate --colour gone.json": "unknown colour 'gone.json': expected one of orange, white",
    "evaluate --colour text": "colour text: is no JSON",
    "train --hits 1 --out run --eyes truth --colour white": "expected eyes paper or tracker",
    "throw --out a.gif --ball green": "unknown ball 'green'",
    "demo --ball green": "unknown ball 'green': expected one of orange, white",
    "serves stats --balls 0": "balls 0: expected a whole number",
    "serves stats --serves smash": "serves 'smash': expected one of human, constant, hard, lob",
    "serves stats --camera nikon": "camera 'nikon': expected one of gazebo",
    "serves stats --seed -1": "seed -1: expected",
    "serves from-flight": "--out PATH",
    "serves from-flight gone.csv --out made.csv": "gone.csv: no such file",
    "serves from-flight flight.csv --out made.csv": "flight.csv: line 9: 'nan'",
    "serves from-flight empty --out made.csv": "empty: 0 files, none of them a flight",
    "serves nonsense": "Available subcommands: from-flight, stats",
    "demo --seed -1": "seed -1: expected a whole number",
    "demo --out text": "text: is a file; expected a folder",
    "doctor extra": "Unrecognized options: extra",
    "nonsense": "demo, train, evaluate, suite, detect, calibrate, serves, predict, throw, bench,",
    "--nonsense": "Unrecognized or misplaced options: --nonsense",
}


def complaint(capfd, line, folder):
    """Return what bad input is told, after checking that it is one line and writes no file."""
    before = sorted(folder.iterdir())
    status, out, err = ask(capfd, *line.split(), "--json")
    assert (status, out) == (2, "")
    assert err.startswith("rotorpong: ")
    assert err.count("\n") == 1
    assert err.endswith("\n")
    assert "---" not in err
    assert sorted(folder.iterdir()) == before
    return err


@pytest.mark.parametrize("line", BAD)
def test_bad_input_is_status_2_and_one_line_that_says_what_was_expected(here, capfd, line):
    assert BAD[line] in complaint(capfd, line, here)


@pytest.mark.parametrize("line", ["train --hits 1 --out", "evaluate --serves"])
def test_an_empty_name_is_bad_input(here, capfd, line):
    status, out, err = ask(capfd, *line.split(), "")
    assert (status, out, err.count("\n")) == (2, "", 1)


def test_a_place_that_cannot_be_written_is_bad_input(here, capfd):
    for line in (
        "train --hits 1 --eyes truth --out /proc/run",
        "detect ball.png --out /proc/marked",
        "detect ball.png --out text/marked",
    ):
        status, out, err = ask(capfd, *line.split(), "--json")
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert "cannot" in err


def test_a_truncated_video_is_one_line_of_ours_and_none_of_the_decoders(here):
    writer = cv2.VideoWriter("whole.mp4", cv2.VideoWriter_fourcc(*"mp4v"), 30, (640, 360))
    for _ in range(10):
        writer.write(ball_picture())
    writer.release()
    whole = (here / "whole.mp4").read_bytes()
    (here / "truncated.mp4").write_bytes(whole[: len(whole) // 2])
    out, err = shell("detect", "truncated.mp4", "--json").communicate(timeout=60)
    said = "truncated.mp4: not a video that OpenCV can decode, or damaged"
    assert (out, err) == ("", f"rotorpong: {said}\n")


def is_one_line_of_json(out):
    return out.count("\n") == 1 and out.endswith("\n") and json.loads(out) is not None


@pytest.mark.parametrize(
    ("line", "keys"),
    [
        ("evaluate --player hover --balls 2", {"hits", "hit_rate", "trials"}),
        ("detect ball.png ball.png --camera gazebo", {"pictures"}),
        ("serves stats --balls 2", {"flight_time_s", "hover_hit_rate"}),
        (f"{TRAIN} --out run", {"balls", "hits", "hit_rate", "experience"}),
    ],
)
def test_json_is_one_line_on_stdout_and_nothing_else(here, capfd, line, keys):
    status, out, err = ask(capfd, *line.split(), "--json")
    assert status == 0
    assert is_one_line_of_json(out)
    assert keys <= set(json.loads(out))
    assert err == ""


@pytest.mark.parametrize(
    ("line", "shown"),
    [
        ("evaluate --player hover --balls 2", "hover player"),
        ("detect ball.png", "ball.png"),
        ("serves stats --balls 2", "2 serves human"),
    ],
)
def test_without_json_a_table_is_shown(here, capfd, line, shown):
    status, out, _ = ask(capfd, *line.split())
    assert status == 0
    assert shown in out


def test_train_says_where_it_was_kept(here, capfd):
    line = [*TRAIN.split(), "--out", "run"]
    status, out, err = ask(capfd, *line)
    assert (status, out) == (0, "")
    assert err.startswith("rotorpong: 1 hits of ")
    assert err.endswith("kept in run\n")
    assert ask(capfd, *line, "--json")[0] == 2
    resumed = ask(capfd, *line, "--resume", "--json")
    assert resumed[0] == 0
    assert json.loads(resumed[1])["experience"] == "run"


def test_errors_of_several_lines_become_one(capfd, monkeypatch):
    def run(self):
        raise InputError("first\n  second\tthird")

    monkeypatch.setattr(cli.Doctor, "run", run)
    assert ask(capfd, "doctor") == (2, "", "rotorpong: first second third\n")


@pytest.mark.parametrize("width", ["40", "200"])
def test_a_box_of_the_parser_becomes_one_line_in_any_terminal(capfd, monkeypatch, width):
    monkeypatch.setenv("COLUMNS", width)
    monkeypatch.setenv("FORCE_COLOR", "1")
    status, out, err = ask(capfd, "evaluate", "--nonsense")
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("rotorpong: Unrecognized options: --nonsense")
    assert "\x1b" not in err
    assert not set("─│╭╮╰╯┌┐└┘├┤") & set(err)


@pytest.mark.parametrize("line", ["", "--help", "evaluate --help", "serves --help"])
def test_help_is_on_stdout_and_status_0(capfd, line):
    status, out, err = ask(capfd, *line.split())
    assert status in {0, None}
    assert "usage: rotorpong" in out
    assert err == ""


def test_help_does_not_promise_what_does_not_exist(capfd):
    shown = "".join(ask(capfd, *line.split())[1] for line in ("--help", "evaluate --help"))
    for later in ("--session", "cockpit", "interceptor", "mavlink"):
        assert later not in shown


@pytest.mark.parametrize(
    ("line", "status", "said"),
    [
        ("--help", 0, "usage"),
        ("evaluate --help", 0, "usage"),
        ("--version", 0, "rotorpong 0"),
        ("evaluate --nonsense", 2, "Unrecognized options: --nonsense"),
    ],
)
def test_what_plays_nothing_imports_nothing_heavy(line, status, said):
    code = f"""
import sys
from rotorpong.cli.entry import _run
try:
    _run({line.split()})
finally:
    print("heavy:", *(name for name in {HEAVY} if name in sys.modules))
"""
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.returncode == status
    assert said in result.stdout + result.stderr
    assert result.stdout.endswith("heavy:\n")


def test_the_version_is_one_line_on_stdout(capfd):
    assert ask(capfd, "--version") == (0, f"rotorpong {rotorpong.__version__}\n", "")


def test_a_reader_may_leave_early():
    reading, writing = os.pipe()
    os.close(reading)
    line = ["evaluate", "--player", "hover", "--balls", "1", "--json"]
    process = shell(*line, stdout=writing)
    os.close(writing)
    _, err = process.communicate(timeout=120)
    assert (process.returncode, err) == (0, "")


@pytest.mark.parametrize("kept", [(), ("--workers", "2")])
def test_ctrl_c_is_status_130_and_one_line(here, kept):
    (here / "own.py").write_text(PLAYER.format("open('playing', 'w').close()"))
    line = ["evaluate", "--player", "own.py:Own", "--balls", "100000", "--json"]
    process = shell(*line, *kept, start_new_session=True)
    while not (here / "playing").exists() and process.poll() is None:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out, err) == (130, "", "rotorpong: interrupted\n")

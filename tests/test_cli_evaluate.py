"""`rotorpong evaluate`: what it says of experience, of workers and of others."""

import json
import os

import pytest
from test_cli import PLAYER, SERVE_HEADER, ask, complaint, is_one_line_of_json

from rotorpong.experience import create
from rotorpong.lab import workers as workers_module
from rotorpong.lab.player_settings import PlayerSettings
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import run_of, train


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text").write_text("hello")
    return tmp_path


def test_experience_of_other_eyes_is_accepted_with_a_warning(here, capfd):
    train(Spec(eyes="truth", seed=1), 1, here / "run.sqlite")
    line = ["evaluate", "--player", "hover", "--balls", "1", "--experience", "run.sqlite", "--json"]
    status, out, err = ask(capfd, *line)
    assert status == 0
    assert is_one_line_of_json(out)
    assert err == "rotorpong: run.sqlite was recorded with eyes truth, not paper\n"
    assert ask(capfd, *line, "--eyes", "truth")[2] == ""
    status, _, err = ask(capfd, *line, "--eyes", "truth", "--serves", "constant")
    assert (status, err.count("\n")) == (0, 1)
    assert "serves human, not constant" in err


def test_experience_of_another_ball_or_of_eyes_set_otherwise_is_accepted_with_warnings(here, capfd):
    with create(here / "run.sqlite", run_of(Spec(ball="white"))):
        pass
    line = ["evaluate", "--player", "hover", "--balls", "1", "--experience", "run.sqlite", "--json"]
    assert ask(capfd, *line, "--ball", "white")[2] == ""
    told = ask(capfd, *line, "--circle-fit", "pratt")[2]
    assert told == (
        "rotorpong: run.sqlite was recorded with another ball\n"
        "rotorpong: run.sqlite was recorded with another setting of the eyes\n"
    )


def test_experience_of_a_player_set_otherwise_is_accepted_with_a_warning(here, capfd):
    settings = PlayerSettings(exploration_sd=0.05, plane_distance=2.0)
    spec = Spec(eyes="truth", player_settings=settings, control="feed-forward")
    train(spec.check(), 1, here / "run.sqlite")
    line = "evaluate --eyes truth --balls 1 --experience run.sqlite --json"
    same = f"{line} --plane-distance-m 2 --exploration-sd-m 0.05 --control feed-forward"
    status, out, err = ask(capfd, *same.split())
    assert (status, err) == (0, "")
    told = json.loads(out)["player_settings"]
    assert (told["plane_distance_m"], told["exploration_sd_m"]) == (2.0, 0.05)
    assert ask(capfd, *line.split())[2] == (
        "rotorpong: run.sqlite was recorded with another setting of the player\n"
        "rotorpong: run.sqlite was recorded with another control\n"
    )
    assert ask(capfd, *line.split(), "--player", "hover")[2] == ""


def test_an_evaluation_says_which_ball_was_thrown_and_how_the_eyes_were_set(here, capfd):
    plain = ["evaluate", "--player", "hover", "--balls", "1", "--json"]
    line = [*plain, "--ball", "white", "--diameter", "float"]
    status, out, _ = ask(capfd, *line)
    told = json.loads(out)
    assert (status, told["eyes"], told["ball"]) == (0, "paper", "white")
    settings = {"colour": "white", "circle_fit": "kasa", "diameter": "float"}
    assert told["eye_settings"] == settings
    usual = json.loads(ask(capfd, *plain)[1])
    assert usual["eye_settings"] == {"colour": "orange", "circle_fit": "kasa", "diameter": "whole"}
    kept = usual.keys() - {"ball", "eye_settings"}
    assert {key: usual[key] for key in kept} == {key: told[key] for key in kept}


def test_a_file_that_changed_since_the_experience_is_told_and_one_that_moved_is_not(here, capfd):
    (here / "serve.csv").write_text(SERVE_HEADER + "2,0,0.3,-7,0,2,0,0,0,0.15,0.88,0.25\n")
    train(Spec(eyes="truth", serves="serve.csv"), 1, here / "run.sqlite")
    line = "evaluate --player hover --eyes truth --balls 1 --experience run.sqlite --json --serves"
    assert ask(capfd, *line.split(), "serve.csv")[2] == ""
    (here / "serve.csv").rename(here / "same.csv")
    assert ask(capfd, *line.split(), "same.csv")[2] == ""
    (here / "serve.csv").write_text(SERVE_HEADER + "2,0,0.3,-7,0,2.1,0,0,0,0.15,0.88,0.25\n")
    said = "rotorpong: run.sqlite was recorded with another serves serve.csv\n"
    assert ask(capfd, *line.split(), "serve.csv")[2] == said


def test_what_a_players_own_code_prints_or_leaves_does_not_spoil_the_json(here, capfd, monkeypatch):
    (here / "own.py").write_text(PLAYER.format("print('look at me'); raise SystemExit(0)"))
    line = ["evaluate", "--player", "own.py:Own", "--balls", "11", "--json"]
    monkeypatch.setattr(workers_module, "cores", lambda: 2)
    for workers in ("1", "2"):
        status, out, err = ask(capfd, *line, "--workers", workers)
        assert status == 0
        assert is_one_line_of_json(out)
        assert {trial["outcome"] for trial in json.loads(out)["trials"]} == {"fault"}
        assert err.count("look at me") == 11


def test_a_worker_that_dies_is_one_line(here, capfd, monkeypatch):
    monkeypatch.setattr(workers_module, "cores", lambda: 2)
    (here / "own.py").write_text("import os\n" + PLAYER.format("os._exit(1)"))
    line = ["evaluate", "--player", "own.py:Own", "--balls", "11", "--workers", "2", "--json"]
    status, out, err = ask(capfd, *line)
    assert (status, out) == (2, "")
    assert err == "rotorpong: a worker process died, for want of memory or killed\n"


def test_an_evaluation_is_compared_with_others_of_the_same_balls(here, capfd):
    """Hover against itself is a draw; with the oracle beside it, hover's skill is 0."""
    for player in ("hover", "oracle"):
        line = f"evaluate --player {player} --eyes truth --balls 4 --json"
        (here / f"{player}.json").write_text(ask(capfd, *line.split())[1])
    line = "evaluate --player hover --eyes truth --balls 4 --against hover.json oracle.json"
    told = json.loads(ask(capfd, *line.split(), "--json")[1])
    assert [(one["file"], one["lost"] > 0) for one in told["against"]] == [
        ("hover.json", False),
        ("oracle.json", True),
    ]
    assert told["skill"] == 0.0
    shown = ask(capfd, *line.split())[1]
    assert "0 won, 0 lost, p = 1" in shown
    assert "skill" in shown
    for bad, said in (
        ("--seed 1", "hover.json: seed 0, here 1; expected the same balls"),
        ("--against text", "text: is no JSON; expected what"),
    ):
        assert said in complaint(capfd, f"{line} {bad}", here)


def test_more_workers_than_cores_are_not_started(here, capfd, monkeypatch):
    monkeypatch.setattr(workers_module, "cores", lambda: 1)
    line = ["evaluate", "--player", "hover", "--balls", "11", "--workers", "1000", "--json"]
    status, out, err = ask(capfd, *line)
    assert (status, err) == (0, "rotorpong: 1000 workers asked for, 1 cores available: 1 play\n")
    assert is_one_line_of_json(out)


def test_a_player_that_cannot_be_loaded_in_a_worker_is_one_line(here, capfd, monkeypatch):
    monkeypatch.setattr(workers_module, "cores", lambda: 2)
    only_here = f"import os\nassert os.getpid() == {os.getpid()}, 'elsewhere'\n"
    (here / "own.py").write_text(only_here + PLAYER.format("pass"))
    line = ["evaluate", "--player", "own.py:Own", "--balls", "11", "--workers", "2", "--json"]
    status, out, err = ask(capfd, *line)
    assert (status, out) == (2, "")
    assert err == "rotorpong: player 'own.py:Own': AssertionError: elsewhere\n"

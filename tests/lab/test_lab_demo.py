"""The demo from end to end, small: two demonstrations, one own hit, six balls."""

import json
import math

import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import OUTCOMES
from rotorpong.experience.shipped import read_demonstrations
from rotorpong.lab.demo import DemoSize, demo_table, run_demo
from rotorpong.lab.demo_files import FILES, REPORT, finished_together
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import Spec
from rotorpong.lab.statistics import wilson_interval
from rotorpong.lab.train import knowledge_of

SMALL = DemoSize(demonstrations=2, hits=1, balls=6)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    told = []
    out = tmp_path_factory.mktemp("demo") / "new" / "folder"
    result = run_demo(out, workers=1, size=SMALL, progress=lambda *step: told.append(step))
    return result, told


def visible(folder):
    return sorted(path.name for path in folder.iterdir())


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_it_leaves_exactly_its_four_files(demo):
    result, _ = demo
    assert visible(result.out) == sorted(FILES)
    assert set(result.as_json()["files"].values()) == {str(result.out / name) for name in FILES}


def test_results_json_is_what_it_returns(demo):
    result, _ = demo
    written = json.loads((result.out / "results.json").read_text())
    assert written == json.loads(json.dumps(result.found, allow_nan=False))


def test_every_player_met_all_balls_and_its_numbers_agree_with_each_other(demo):
    for player in demo[0].found["players"]:
        outcomes = player["outcomes"]
        assert len(outcomes) == player["balls"] == SMALL.balls
        assert set(outcomes) <= set(OUTCOMES)
        assert player["hits"] == outcomes.count("hit")
        assert player["hit_rate"] == player["hits"] / SMALL.balls
        assert player["hit_rate_interval"] == wilson_interval(player["hits"], SMALL.balls)


def test_the_numbers_after_training_are_those_of_evaluate_with_its_experience(demo):
    result, _ = demo
    _, known = knowledge_of(result.out / "experience.sqlite")
    after = [r.outcome for r in evaluate(Spec(), SMALL.balls, knowledge=known)]
    assert result.found["players"][2]["outcomes"] == after


def test_the_training_it_reports_is_the_training_it_kept(demo):
    result, _ = demo
    _, known = knowledge_of(result.out / "experience.sqlite")
    training = result.found["training"]
    assert training["outcomes"] == [trial.outcome for trial in known.trials]
    assert training["hits"] == SMALL.hits
    assert known.demonstrations == read_demonstrations(result.out / "demonstrations.json")
    assert result.found["demonstrations"]["kept"] == len(known.demonstrations) == 2


def test_the_comparison_is_an_exact_sign_test(demo):
    found = demo[0].found
    pairs = list(zip(*(player["outcomes"] for player in found["players"][1:]), strict=True))
    won = sum(a != "hit" and b == "hit" for a, b in pairs)
    lost = sum(a == "hit" and b != "hit" for a, b in pairs)
    tail = sum(math.comb(won + lost, k) for k in range(min(won, lost) + 1)) / 2 ** (won + lost)
    assert (found["comparison"]["won"], found["comparison"]["lost"]) == (won, lost)
    assert found["comparison"]["p_value"] == pytest.approx(min(1.0, 2 * tail))


def test_progress_of_each_part_ends_at_its_end(demo):
    _, told = demo
    last = {what: (done, total) for what, done, total in told}
    assert all(done == total for done, total in last.values())
    assert list(last) == [
        "demonstrations", "hover", "before training", "own hits", "after training", "report"
    ]  # fmt: skip


def test_the_table_shows_the_three_players_with_their_hits(demo):
    result, _ = demo
    table = demo_table(result)
    assert table.row_count == 3
    assert list(table.columns[2].cells) == [str(p["hits"]) for p in result.found["players"]]


def test_again_into_the_same_folder_all_at_once_gives_the_same_and_keeps_what_is_not_its_own(demo):
    result, _ = demo
    (result.out / "notes.txt").write_text("mine")
    again = run_demo(result.out, workers=2, size=SMALL)
    assert json.dumps(again.found) == json.dumps(result.found)
    assert visible(again.out) == sorted((*FILES, "notes.txt"))
    assert (again.out / "notes.txt").read_text() == "mine"
    (result.out / "notes.txt").unlink()


@pytest.mark.parametrize("stage", ["demonstrations", "own hits"])
def test_an_interrupted_demo_leaves_what_was_there(demo, stage):
    result, _ = demo
    before = contents(result.out)

    def interrupt(what, done, total):
        if what == stage:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_demo(result.out, workers=1, progress=interrupt, size=DemoSize(2, 1, 1))
    assert contents(result.out) == before


def test_files_are_put_in_place_together_or_not_at_all(tmp_path):
    def write(folder):
        for name in FILES:
            (folder / name).write_text(name)

    def fail():
        with finished_together(tmp_path) as draft:
            write(draft)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert visible(tmp_path) == []
    with finished_together(tmp_path) as draft:
        write(draft)
        assert [path for path in tmp_path.iterdir() if path.is_file()] == []
    assert contents(tmp_path) == {name: name.encode() for name in FILES}


def test_the_log_of_an_older_experience_is_not_folded_into_the_new_one(tmp_path):
    (tmp_path / "experience.sqlite-wal").write_text("old")
    with finished_together(tmp_path) as draft:
        for name in FILES:
            (draft / name).touch()
    assert visible(tmp_path) == sorted(FILES)


def test_a_file_in_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="expected a folder"):
            run_demo(out, size=SMALL)


@pytest.mark.parametrize("name", FILES)
def test_a_file_of_the_same_name_that_is_not_its_own_is_refused_and_kept(tmp_path, name):
    (tmp_path / name).write_text("<p>mine</p>")
    with pytest.raises(InputError, match="not written by a demo"):
        run_demo(tmp_path, size=SMALL)
    assert contents(tmp_path) == {name: b"<p>mine</p>"}


def test_a_folder_named_like_the_report_is_refused(tmp_path):
    (tmp_path / REPORT).mkdir()
    with pytest.raises(InputError, match="is a folder; expected a file"):
        run_demo(tmp_path, size=SMALL)


@pytest.mark.parametrize("bad", [{"seed": -1}, {"workers": 0}])
def test_seeds_and_workers_that_cannot_be_are_refused(tmp_path, bad):
    with pytest.raises(InputError, match="expected a whole number"):
        run_demo(tmp_path / "new", **bad)
    assert not (tmp_path / "new").exists()

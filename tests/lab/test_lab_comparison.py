"""Evaluations of the same balls beside each other."""

import json

import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.comparison import compared, paired, read_evaluation, require_same_balls
from rotorpong.lab.evaluate import Result, header, summary
from rotorpong.lab.spec import Spec


def found(hits, spec=None):
    """The evaluation of a player that hits where `hits` says 1."""
    results = [
        Result(i, "hit" if hit == "1" else "miss", 0.1, None, None, reachable=True)
        for i, hit in enumerate(hits)
    ]
    return summary(spec or Spec("hover"), results)


@pytest.fixture
def kept(tmp_path):
    def keep(name, hits, spec=None):
        (tmp_path / name).write_text(json.dumps(found(hits, spec)))
        return read_evaluation(tmp_path / name)

    return keep


def test_won_and_lost_are_the_balls_that_only_one_hit():
    ours, theirs = ([c == "1" for c in text] for text in ("1110001", "1001000"))
    assert paired(ours, theirs) == {"won": 3, "lost": 1, "p_value": pytest.approx(10 / 16)}
    assert paired(theirs, ours)["p_value"] == paired(ours, theirs)["p_value"]
    assert paired(ours, ours) == {"won": 0, "lost": 0, "p_value": 1.0}


def test_an_evaluation_that_was_printed_is_read_and_compared(kept):
    other = kept("other.json", "1100", Spec("paper"))
    told = compared(found("0111"), [other])
    assert told["skill"] is None
    (against,) = told["against"]
    assert (against["file"], against["player"]) == (str(other.path), "paper")
    assert (against["won"], against["lost"], against["hits"]) == (2, 1, 2)


def test_skill_is_0_for_hover_and_1_for_the_oracle(kept):
    hover = kept("hover.json", "1000")
    oracle = kept("oracle.json", "1110", Spec("oracle", "truth"))
    assert compared(found("1100", Spec()), [oracle, hover])["skill"] == pytest.approx(0.5)
    assert compared(found("0000", Spec()), [oracle, hover])["skill"] == pytest.approx(-0.5)
    assert compared(hover.found, [oracle])["skill"] == 0.0
    assert compared(oracle.found, [hover])["skill"] == 1.0
    assert compared(found("1100", Spec()), [hover])["skill"] is None
    elsewhere = kept("elsewhere.json", "1110", Spec("oracle", "truth", "ardrone2"))
    assert compared(found("1100", Spec()), [hover, elsewhere])["skill"] is None
    no_better = kept("no_better.json", "1000", Spec("oracle", "truth"))
    assert compared(found("1100", Spec()), [hover, no_better])["skill"] is None


@pytest.mark.parametrize(
    ("spec", "hits", "said"),
    [
        (Spec("hover", seed=1), "0101", "seed 1, here 0; expected the same balls"),
        (Spec("hover", serves="lob"), "0101", "serves lob, here human"),
        (Spec("hover", randomize=True), "0101", "randomize True, here False"),
        (Spec("hover"), "010", "balls 3, here 4"),
    ],
)
def test_other_balls_are_refused(kept, spec, hits, said):
    other = kept("other.json", hits, spec)
    with pytest.raises(InputError, match=rf"other\.json: {said}"):
        require_same_balls(header(Spec("paper"), 4), other)
    require_same_balls(header(Spec("paper", vehicle="ardrone2"), 4), kept("same.json", "0000"))


def test_a_serve_file_is_known_by_what_it_holds(kept, tmp_path):
    text = "x_m,y_m,z_m,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s,"
    text += "drag_per_m,restitution,friction\n2,0,0.3,-7,0,2,0,0,0,0.15,0.88,0.25\n"
    one, other = tmp_path / "one.csv", tmp_path / "other.csv"
    one.write_text(text)
    other.write_text(text)
    same = kept("same.json", "01", Spec("hover", serves=str(one)))
    require_same_balls(header(Spec("hover", serves=str(other)), 2), same)
    other.write_text(text.replace("0.3", "0.4"))
    with pytest.raises(InputError, match="expected the same balls"):
        require_same_balls(header(Spec("hover", serves=str(other)), 2), same)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is no JSON"),
        ("[" * 100_000, "is no JSON"),
        ("\udcff", "is no JSON"),
        ("[1, 2]", "is no evaluation"),
        ('{"trials": []}', "is no evaluation"),
        ({"trials": None}, "is no evaluation"),
        ({"trials": [3]}, "is no evaluation"),
        ({"balls": 9}, "is no evaluation"),
        ({"hits": 9}, "is no evaluation"),
        ({"contents": 3}, "is no evaluation"),
        ({"trials": [{"outcome": "hit"}, {"outcome": "win"}]}, "is no evaluation"),
    ],
)
def test_what_is_no_evaluation_is_one_line(tmp_path, text, said):
    path = tmp_path / "file.json"
    if isinstance(text, dict):
        text = json.dumps(found("10") | text)
    path.write_text(text, "utf-8", "surrogateescape")
    with pytest.raises(InputError, match=rf"file\.json: {said}; expected what") as error:
        read_evaluation(path)
    assert "\n" not in str(error.value)
    for gone in (tmp_path, tmp_path / "gone"):
        with pytest.raises(InputError, match="no such file; expected what"):
            read_evaluation(gone)

"""Rows of `bench players`: who plays, after how many hits, on the same balls."""

import pytest
from lab_bench import STILL, write_player

from rotorpong.conventions import InputError
from rotorpong.experience import Trial
from rotorpong.lab.bench import player_rows
from rotorpong.lab.bench.player_rows import Entrant, Size, Standing, curve_of, entrants, until
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.suites import Order
from rotorpong.lab.bench.tables import rows_table
from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.spec import PLAYERS, Spec


def trials(outcomes):
    return tuple(Trial(i, one, 0.0, None, None, None) for i, one in enumerate(outcomes))


def test_everybody_plays_and_a_users_own_player_too(tmp_path):
    own = write_player(tmp_path, STILL)
    found = entrants(own, seed=3)
    assert {one.spec.player for one in found} == {*PLAYERS, own}
    assert {one.spec.seed for one in found} == {3}
    assert len({one.name for one in found}) == len(found)


def test_all_meet_the_same_serves_with_the_same_eyes_but_for_the_bound():
    eyes = {one.spec.player: one.spec.eyes for one in entrants()}
    assert eyes.pop("oracle") == "truth"
    assert set(eyes.values()) == {"paper"}
    assert {one.spec.serves for one in entrants()} == {"human"}


def test_trials_are_cut_at_a_hit():
    kept = trials(["miss", "hit", "miss", "miss", "hit", "miss"])
    assert [len(until(kept, hits)) for hits in (0, 1, 2, 3)] == [0, 2, 5, 6]


def test_a_learner_is_measured_before_and_after_and_the_others_once():
    size = Size(4, (0, 1))
    paper, hover = (
        curve_of(Entrant(name, Spec(name, eyes="truth")), size) for name in ("paper", "hover")
    )
    assert [standing.own_hits for standing in paper] == [0, 1]
    assert [standing.own_hits for standing in hover] == [0]
    untrained = evaluate(Spec("paper", eyes="truth"), 4)
    assert paper[0].hits == sum(one.outcome == "hit" for one in untrained)


def test_a_row_has_rate_and_interval_in_per_cent():
    row = player_rows._row(player_rows.PAPERS, Standing(170, 50, 200))
    assert (row.value, row.unit, row.target, row.met) == (25.0, "% of 200 balls", 30.0, False)
    low, high = row.interval
    assert (low, high) == (pytest.approx(19.5, abs=0.1), pytest.approx(31.4, abs=0.1))
    assert row.as_json()["interval"] == (low, high)
    assert player_rows._row("hover", Standing(0, 0, 200)).target is None


def test_a_table_shows_intervals_beside_values():
    column = rows_table((Row("x", 25.0, "%", interval=(19.5, 31.4)), Row("y", 1.0, "m"))).columns[1]
    assert list(column.cells) == ["25 (19.5 - 31.4)", "1"]


def test_curves_are_drawn_with_their_intervals():
    curves = {
        "still": (Standing(0, 1, 20),),
        "learns": (Standing(0, 2, 20), Standing(9, 8, 20)),
    }
    figure = player_rows.learning_curves(curves)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(labels) == ["learns", "still: 5.0 %"]
    (drawn,) = figure.axes[0].containers
    assert list(drawn.lines[0].get_xdata()) == [0, 9]
    assert list(drawn.lines[0].get_ydata()) == [10.0, 40.0]


@pytest.mark.parametrize(
    ("order", "said"),
    [
        (Order("world", player="own.py:Own"), "--player with bench world: belongs to bench play"),
        (Order("players", player="paper"), "--player paper: plays anyway or is none; expected"),
        (Order("players", player="gone.py:Own"), "no file 'gone.py'"),
    ],
)
def test_bad_orders_are_refused(order, said):
    with pytest.raises(InputError) as refusal:
        order.check()
    assert said in str(refusal.value)

"""Wilson's interval against scipy's, McNemar's test against the binomial sum."""

from math import comb

import pytest
from scipy.stats import binomtest

from rotorpong.lab.statistics import mcnemar, rate, skill, wilson_interval


@pytest.mark.parametrize("trials", [1, 2, 10, 137, 1000])
def test_the_interval_is_wilsons(trials):
    for hits in {0, 1, trials // 3, trials // 2, trials - 1, trials}:
        expected = binomtest(hits, trials).proportion_ci(0.95, method="wilson")
        assert wilson_interval(hits, trials) == pytest.approx(tuple(expected), abs=1e-12)


@pytest.mark.parametrize("trials", [1, 3, 50, 999])
def test_the_interval_holds_the_rate_at_both_ends_of_the_scale(trials):
    assert wilson_interval(0, trials)[0] == 0.0
    assert wilson_interval(trials, trials)[1] == 1.0
    for hits in range(0, trials + 1, max(1, trials // 50)):
        low, high = wilson_interval(hits, trials)
        assert 0.0 <= low <= rate(hits, trials) <= high <= 1.0


def test_hits_and_misses_are_treated_alike():
    low, high = wilson_interval(30, 100)
    other = wilson_interval(70, 100)
    assert other == pytest.approx((1.0 - high, 1.0 - low))


def test_more_trials_make_it_narrower():
    widths = [high - low for low, high in (wilson_interval(n // 4, n) for n in (8, 80, 800))]
    assert widths[0] > widths[1] > widths[2]


@pytest.mark.parametrize(("won", "lost"), [(0, 1), (5, 5), (14, 13), (94, 25), (170, 9)])
def test_mcnemars_test_sums_both_tails_of_the_binomial(won, lost):
    n, least = won + lost, min(won, lost)
    tail = sum(comb(n, k) for k in range(least + 1)) / 2**n
    assert mcnemar(won, lost) == mcnemar(lost, won) == pytest.approx(min(1.0, 2.0 * tail))


def test_nothing_that_changed_is_no_evidence():
    assert mcnemar(0, 0) == 1.0


def test_skill_is_0_at_hover_1_at_the_oracle_and_nothing_without_a_scale():
    assert [skill(rate, 0.1, 0.9) for rate in (0.1, 0.5, 0.9)] == pytest.approx([0.0, 0.5, 1.0])
    assert skill(0.5, 0.4, 0.4) is skill(0.5, 0.6, 0.4) is None


def test_nothing_has_no_rate():
    assert rate(0, 0) is None
    assert wilson_interval(0, 0) is None

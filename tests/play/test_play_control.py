"""Every player that flies a motion flies it open loop, ahead, or in closed loop."""

from dataclasses import replace

import numpy as np
import pytest
from test_play_paper import LESSONS, flown, served, trigger_time

from rotorpong.control.plant import UNKNOWN_PLANT, Axis
from rotorpong.play.bandit import BanditPlayer
from rotorpong.play.nearest import NearestPlayer
from rotorpong.play.paper import LONGEST, PaperSettings
from rotorpong.play.single import SinglePlayer

KINDS = (NearestPlayer, SinglePlayer, BanditPlayer)
PROMPT = replace(UNKNOWN_PLANT, axes=(Axis(1e-3),) * 3)


def led(kind, control, plant=PROMPT):
    """Return a drone that was served once, and how far the commands led it."""
    drone = served(kind(LESSONS, PaperSettings(control=control, plant=plant)))
    begin = trigger_time(drone)
    return drone, flown(drone, begin, begin + LONGEST)


@pytest.mark.parametrize("kind", KINDS)
def test_open_is_what_is_flown_unless_asked_otherwise(kind):
    assert served(kind(LESSONS)).commands == led(kind, "open")[0].commands


@pytest.mark.parametrize("control", ["feed_forward", "closed_loop"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_drone_with_no_lag_is_led_as_far_by_every_control(kind, control):
    np.testing.assert_allclose(led(kind, control)[1], led(kind, "open")[1], atol=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_a_drone_that_lags_is_told_to_be_faster(kind):
    told = [
        max(np.hypot(one.forward, one.left) for _, one in led(kind, control, None)[0].commands)
        for control in ("open", "feed_forward")
    ]
    assert told[1] > told[0]


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_of_a_flight_is_carried_to_the_next_serve(kind):
    player = kind(LESSONS, PaperSettings(control="closed_loop"))
    assert served(player).commands == served(player).commands

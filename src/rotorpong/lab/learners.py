"""Players that learn, as training and evaluation know them."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from rotorpong.control.plant import plant_of
from rotorpong.drone import Outcome, Player, Verdict
from rotorpong.experience import Attempt
from rotorpong.lab.control_settings import control_of
from rotorpong.lab.spec import Spec
from rotorpong.play.bandit import BanditPlayer
from rotorpong.play.lessons import Lesson
from rotorpong.play.paper import PaperPlayer, PaperSettings
from rotorpong.play.single import SinglePlayer


class Learner(Player, Protocol):
    """A player whose knowledge is a function of its demonstrations and of trials that are kept."""

    def attempt(self, verdict: Verdict) -> Attempt | None:
        """Return what was tried in the serve just played; `None` if nothing was."""
        ...

    def recall(self, outcome: Outcome, attempt: Attempt | None, reward: float) -> None:
        """Learn from a trial that was kept what `learn` learnt when it was played."""
        ...


def learner_of(spec: Spec, lessons: Sequence[Lesson], *, explore: bool = False) -> Learner:
    """Return the spec's player, one of `LEARNERS`, that knows these lessons and nothing else.

    Raises:
        InputError: fewer than two lessons.
    """
    kinds = {"paper": PaperPlayer, "single": SinglePlayer, "bandit": BanditPlayer}
    return kinds[spec.player](lessons, settings_of(spec), explore=explore)


def settings_of(spec: Spec) -> PaperSettings:
    """Return what the spec says of a player that flies motions.

    Control knows the nominal vehicle, also where trials draw their own.
    """
    control, plant = control_of(spec.control), plant_of(spec.setting().vehicle)
    return replace(spec.player_settings.of_paper(), control=control, plant=plant)

"""Players that learn, as training and evaluation know them."""

from collections.abc import Sequence
from typing import Protocol

from rotorpong.drone import Outcome, Player, Verdict
from rotorpong.experience import Attempt
from rotorpong.lab.spec import Spec
from rotorpong.play.bandit import BanditPlayer
from rotorpong.play.lessons import Lesson
from rotorpong.play.paper import PaperPlayer
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
    return kinds[spec.player](lessons, spec.player_settings.of_paper(), explore=explore)

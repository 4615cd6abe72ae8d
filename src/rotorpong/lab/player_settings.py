"""What can be set about players. What is not asked for is as in `PaperSettings`.

    paper, single    labels, length scale, regularization, tune
    single           primitive
    bandit           length scale, regularization, tune

What is asked for must have an effect on the player chosen.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, get_args

from rotorpong.conventions import InputError
from rotorpong.lab.choices import require_choice
from rotorpong.play.paper import Labels, PaperSettings

OF_CRKR = ("length_scale", "regularization")
TUNED = (*OF_CRKR, "tune")
SETTABLE: Mapping[str, tuple[str, ...]] = {
    "paper": ("labels", *TUNED),
    "single": ("labels", *TUNED, "primitive"),
    "bandit": TUNED,
}


@dataclass(frozen=True, slots=True)
class PlayerSettings:
    """What is asked of a player; None: nothing."""

    labels: str | None = None  # what hitting points are learnt from
    length_scale: float | None = None  # of CrKR, in standard deviations of the demonstrations
    regularization: float | None = None  # lambda of Eq. (6), m^2
    tune: bool | None = None  # both by marginal likelihood
    primitive: int | None = None  # of which demonstration that the eyes saw, from 0

    def check(self, player: str) -> None:
        """Raise InputError if something is unknown or has no effect on this player."""
        for what, given in self._given().items():
            having = [name for name, settable in SETTABLE.items() if what in settable]
            if player not in having:
                raise InputError(
                    f"{_said(what, given)} with player {player!r}: has no effect; expected player "
                    f"{' or '.join(having)}"
                )
            if what in OF_CRKR and not (math.isfinite(given) and given > 0.0):
                raise InputError(f"{_said(what, given)}: expected a positive number")
        if self.labels is not None:
            require_choice("labels", self.labels, get_args(Labels))

    def of_paper(self) -> PaperSettings:
        """Return these settings, the rest as usual."""
        return replace(PaperSettings(), **self._given())

    def as_json(self, player: str) -> dict[str, Any]:
        """Return everything that is settable about this player, as it is."""
        settings = self.of_paper()
        return {what: getattr(settings, what) for what in SETTABLE.get(player, ())}

    def unusual(self, player: str) -> dict[str, Any]:
        """Return what is not as usual."""
        usual = USUAL.as_json(player)
        return {what: is_ for what, is_ in self.as_json(player).items() if is_ != usual[what]}

    def _given(self) -> dict[str, Any]:
        return {what: given for what, given in asdict(self).items() if given is not None}


USUAL = PlayerSettings()


def _said(what: str, given: Any) -> str:
    """Return a setting as it is given to a command."""
    flag = f"--{what.replace('_', '-')}"
    return flag if given is True else f"{flag} {given}"

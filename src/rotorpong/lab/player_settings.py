"""What can be set about players. What is not asked for is as in `PaperSettings`.

    paper, single    labels

What is asked for must have an effect on the player chosen.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, get_args

from rotorpong.conventions import InputError
from rotorpong.lab.choices import require_choice
from rotorpong.play.paper import Labels, PaperSettings

SETTABLE: Mapping[str, tuple[str, ...]] = {"paper": ("labels",), "single": ("labels",)}
AVAILABLE: Mapping[str, tuple[str, ...]] = {"labels": get_args(Labels)}


@dataclass(frozen=True, slots=True)
class PlayerSettings:
    """What is asked of a player; None: nothing."""

    labels: str | None = None  # what hitting points are learnt from

    def check(self, player: str) -> None:
        """Raise InputError if something is unknown or has no effect on this player."""
        for what, given in self._given().items():
            having = [name for name, settable in SETTABLE.items() if what in settable]
            if player not in having:
                raise InputError(
                    f"--{what} {given} with player {player!r}: has no effect; expected player "
                    f"{' or '.join(having)}"
                )
            require_choice(what, given, AVAILABLE[what])

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
        return {what: given for what in AVAILABLE if (given := getattr(self, what)) is not None}


USUAL = PlayerSettings()

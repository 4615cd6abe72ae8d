"""What can be set about players. What is not asked for is as in `PaperSettings`.

    nearest    trigger, plane distance
    paper      these; labels, length scale, regularization, tune; exploration;
               selection, temperature, deviations, learning from misses
    single     as paper, but no mixture: a primitive in place of what is set of it
    bandit     as paper, but neither labels nor exploration, which are its own

What is asked for must have an effect on the player chosen. Labels and exploration have theirs while
a player trains: in an evaluation they only say which player it is.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, get_args

from rotorpong.conventions import InputError
from rotorpong.lab.choices import require_choice
from rotorpong.learning.mixture import RULES
from rotorpong.play.paper import Labels, PaperSettings, Trigger

OF_TRIGGER = ("trigger", "plane_distance")
OF_CRKR = ("length_scale", "regularization")
TUNED = (*OF_CRKR, "tune")
OF_MIXTURE = ("selection", "temperature", "deviations", "learn_from_misses")
SETTABLE: Mapping[str, tuple[str, ...]] = {
    "nearest": OF_TRIGGER,
    "single": ("labels", *TUNED, *OF_TRIGGER, "exploration_sd", "primitive"),
    "paper": ("labels", *TUNED, *OF_TRIGGER, "exploration_sd", *OF_MIXTURE),
    "bandit": (*TUNED, *OF_TRIGGER, *OF_MIXTURE),
}
DECIDING_ONCE = tuple(SETTABLE)  # at the trigger, on a motion that is flown under some control
CHOICES = {"labels": get_args(Labels), "trigger": get_args(Trigger), "selection": RULES}
OF_RULE = {"temperature": "temperature", "deviations": "ucb"}
NEAREST_PLANE = 0.8  # m: from nearer, the ball is there before the shortest motion is over, 0.2 s
FARTHEST_PLANE = 4.0  # m: half of the human serves are thrown from nearer
BETWEEN = {
    "plane_distance": (NEAREST_PLANE, FARTHEST_PLANE),
    "exploration_sd": (0.0, 1.0),  # m: the drone goes no farther
    "temperature": (1e-3, 1e3),
    "deviations": (0.0, 100.0),
}
IN_METRES = ("plane_distance", "exploration_sd")
UNMENTIONED: Mapping[str, Any] = {
    **{"labels": "commanded", "length_scale": 3.0, "regularization": 0.1, "tune": False},
    **{"trigger": "plane", "plane_distance_m": 2.5, "exploration_sd_m": 0.10},
    **{"selection": "paper", "learn_from_misses": False},
}
"""How runs were that say nothing of it: those of version 0.1.0."""


@dataclass(frozen=True, slots=True)
class PlayerSettings:
    """What is asked of a player; None: nothing."""

    labels: str | None = None  # what hitting points are learnt from
    length_scale: float | None = None  # of CrKR, in standard deviations of the demonstrations
    regularization: float | None = None  # lambda of Eq. (6), m^2
    tune: bool | None = None  # both by marginal likelihood
    trigger: str | None = None  # whether depth or distance of the ball sets it going
    plane_distance: float | None = None  # m, at which it does
    exploration_sd: float | None = None  # m, each axis of the hitting point, in training
    selection: str | None = None  # rule by which primitives are weighed
    temperature: float | None = None  # of rule temperature, in units of the reward
    deviations: float | None = None  # of rule ucb
    learn_from_misses: bool | None = None  # what primitives are worth
    primitive: int | None = None  # of which demonstration that the eyes saw, from 0

    def check(self, player: str) -> None:
        """Raise InputError if something is unknown or has no effect on this player."""
        for what, given in self._given().items():
            _require_effect(what, given, player)
            _require_number(what, given)
            if what in CHOICES:
                require_choice(what, given, CHOICES[what])
        for what, rule in OF_RULE.items():
            given = getattr(self, what)
            if given is not None and self.selection != rule:
                raise InputError(f"{_said(what, given)}: has no effect without --selection {rule}")

    def of_paper(self) -> PaperSettings:
        """Return these settings, the rest as usual."""
        given, usual = self._given(), PaperSettings()
        names = {"selection": "rule", "temperature": "temperature", "deviations": "deviations"}
        rule = {name: given.pop(what) for what, name in names.items() if what in given}
        return replace(usual, selection=replace(usual.selection, **rule), **given)

    def as_json(self, player: str) -> dict[str, Any]:
        """Return everything that is settable about this player and has an effect, as it is."""
        settings = self.of_paper()
        rule = settings.selection
        told = {what: getattr(rule, what) for what, its in OF_RULE.items() if its == rule.rule}
        told["selection"] = rule.rule
        named = [what for what in SETTABLE.get(player, ()) if what in told or what not in OF_RULE]
        return {_key(what): told.get(what, getattr(settings, what, None)) for what in named}

    def unusual(self, player: str) -> dict[str, Any]:
        """Return what is not as it was in runs that do not mention it."""
        told = self.as_json(player)
        return {what: is_ for what, is_ in told.items() if is_ != UNMENTIONED.get(what)}

    def _given(self) -> dict[str, Any]:
        return {what: given for what, given in asdict(self).items() if given is not None}


USUAL = PlayerSettings()


def _require_effect(what: str, given: Any, player: str) -> None:
    having = [name for name, settable in SETTABLE.items() if what in settable]
    if player not in having:
        raise InputError(
            f"{_said(what, given)} with player {player!r}: has no effect; expected player "
            f"{' or '.join(having)}"
        )


def _require_number(what: str, given: Any) -> None:
    if what in OF_CRKR and not (math.isfinite(given) and given > 0.0):
        raise InputError(f"{_said(what, given)}: expected a positive number")
    if what in BETWEEN and not BETWEEN[what][0] <= given <= BETWEEN[what][1]:
        low, high = BETWEEN[what]
        unit = " m" if what in IN_METRES else ""
        raise InputError(f"{_said(what, given)}: expected a number from {low:g} to {high:g}{unit}")


def _key(what: str) -> str:
    """Return how a setting is called outside, with its unit."""
    return f"{what}_m" if what in IN_METRES else what


def _said(what: str, given: Any) -> str:
    """Return a setting as it is given to a command."""
    flag = f"--{_key(what).replace('_', '-')}"
    return flag if given is True else f"{flag} {given}"

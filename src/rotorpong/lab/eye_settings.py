"""Which eyes there are, and what can be set about them.

    paper      colour, circle fit, diameter
    tracker    colour
    truth      nothing: they look at no frame

What is not asked for is as the paper has it: Kasa's circle, whole pixels, and the colour of the
ball that is thrown. What is asked for must have an effect on the eyes chosen.
"""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from rotorpong.conventions import InputError
from rotorpong.lab.choices import require_choice
from rotorpong.vision.circles import FITS, CircleFit
from rotorpong.vision.colour import COLOURS, Colour
from rotorpong.vision.colour_files import read_colour

SETTABLE = {
    "truth": (),
    "paper": ("colour", "circle_fit", "diameter"),
    "tracker": ("colour",),
}
EYES = tuple(SETTABLE)
CIRCLE_FITS: tuple[CircleFit, ...] = tuple(FITS)
DIAMETERS = ("whole", "float")
PAPERS_FIT, PAPERS_DIAMETER = "kasa", "whole"


@dataclass(frozen=True, slots=True)
class EyeSettings:
    """What is asked of eyes; None: nothing."""

    circle_fit: str | None = None  # how a circle is put through the ball's outline
    diameter: str | None = None  # in the picture: whole pixels, as in Fig. 4, or not
    colour: str | None = None  # that they look for: a name, or a file of `calibrate colour`

    def check(self, eyes: str, ball: str = "orange") -> None:
        """Raise InputError if something is unknown or has no effect.

        Args:
            eyes: that are chosen.
            ball: its colour.
        """
        require_effect(self, eyes)
        if self.circle_fit is not None:
            require_choice("circle fit", self.circle_fit, CIRCLE_FITS)
        if self.diameter is not None:
            require_choice("diameter", self.diameter, DIAMETERS)
        self.colour_of(ball)

    @property
    def fit(self) -> CircleFit:
        """How a circle is put through the ball's outline."""
        return cast("CircleFit", self.circle_fit or PAPERS_FIT)

    @property
    def whole_pixels(self) -> bool:
        """Whether the ball's diameter is rounded to whole pixels."""
        return (self.diameter or PAPERS_DIAMETER) == "whole"

    def colour_of(self, ball: str) -> Colour:
        """Return the colour to look for when a ball of this colour is thrown.

        Raises:
            InputError: neither a name nor a readable file.
        """
        return colour_named(ball if self.colour is None else self.colour)

    def digest(self, ball: str) -> str | None:
        """Return a digest of the colour looked for; None where a name says it all."""
        colour = replace(self.colour_of(ball), name="")
        if colour in (replace(known, name="") for known in COLOURS.values()):
            return None
        return hashlib.sha256(repr(colour).encode()).hexdigest()

    def as_json(self, eyes: str, ball: str) -> dict[str, str]:
        """Return everything that is settable about these eyes, as it is."""
        found = {
            "colour": self.colour or ball,
            "circle_fit": self.fit,
            "diameter": self.diameter or PAPERS_DIAMETER,
        }
        return {what: found[what] for what in SETTABLE[eyes]}

    def unusual(self, eyes: str, ball: str) -> dict[str, Any]:
        """Return what is not as the paper has it, but for a colour that `digest` tells."""
        usual = NOTHING_SET.as_json(eyes, ball)
        found = {**self.as_json(eyes, ball), "colour": self._known_colour(ball)}
        return {what: found[what] for what in usual if found[what] != usual[what]}

    def _known_colour(self, ball: str) -> str:
        """Return the name of the known colour that is looked for; the ball's if it is another."""
        colour = replace(self.colour_of(ball), name="")
        known = [name for name, one in COLOURS.items() if replace(one, name="") == colour]
        return known[0] if known else ball


NOTHING_SET = EyeSettings()


def require_effect(settings: EyeSettings, eyes: str) -> None:
    """Raise InputError if something is set that these eyes do not have."""
    for what in ("circle_fit", "diameter", "colour"):
        given = getattr(settings, what)
        having = [name for name, settable in SETTABLE.items() if what in settable]
        if given is not None and eyes not in having:
            flag = f"--{what.replace('_', '-')}"
            raise InputError(
                f"{flag} {given} with eyes {eyes!r}: has no effect; expected eyes "
                f"{' or '.join(having)}"
            )


def colour_named(given: str) -> Colour:
    """Return a colour by name, or from a file of `calibrate colour`.

    Raises:
        InputError: neither of them.
    """
    if given in COLOURS:
        return COLOURS[given]
    if not (given and Path(given).exists()):
        require_choice("colour", given, tuple(COLOURS), "or a file of `calibrate colour`")
    return read_colour(given)

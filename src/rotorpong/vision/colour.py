"""The colour of a ball, in OpenCV's HSV: hue 0..180, saturation and value 0..255."""

from dataclasses import dataclass

from rotorpong.conventions import InputError

HUES = 180
NO_HUE = 150  # limits this far apart in hue take nearly all of them


@dataclass(frozen=True, slots=True)
class Colour:
    """A ball's colour in OpenCV's HSV: limits of its pixels, and the mean of a typical ball."""

    name: str
    core: tuple[int, int, int]  # lower limits that at least one pixel of a ball keeps
    lower: tuple[int, int, int]  # and all of its pixels
    upper: tuple[int, int, int]
    typical: tuple[int, int, int]

    @property
    def has_hue(self) -> bool:
        """Whether its hue tells the ball from others: not so for white, grey, black."""
        return self.upper[0] - self.lower[0] < NO_HUE


ORANGE = Colour("orange", (0, 140, 90), (0, 110, 80), (24, 255, 255), (11, 200, 215))
WHITE = Colour("white", (0, 0, 200), (0, 0, 175), (180, 60, 255), (90, 20, 235))
COLOURS = {colour.name: colour for colour in (ORANGE, WHITE)}


def as_colour(colour: Colour | str) -> Colour:
    """Return a colour, or the one of this name.

    Raises:
        InputError: there is none of this name.
    """
    if isinstance(colour, Colour):
        return colour
    if colour not in COLOURS:
        raise InputError(f"unknown colour {colour!r}; available: {', '.join(COLOURS)}")
    return COLOURS[colour]

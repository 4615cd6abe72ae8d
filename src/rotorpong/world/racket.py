"""The racket and the hull that carry the game: what the ball can touch on the drone.

The blade is an elliptic disc, facing forward, fixed to the body; the hull a flat cylinder about the
centre of mass. Body frame, metres. The impulse of a 2.7 g ball on the drone is neglected. A ball of
7.5 m/s would change the velocity of an AR.Drone (0.43 kg) by 0.05 m/s on cardboard and 0.085 m/s on
rubber, its pitch rate by 1.2 to 2 rad/s, and would itself leave 3 % slower; the drone of
tum_simulator is 3.5 times as heavy.
"""

from typing import NamedTuple

from rotorpong.physics.ball import CARDBOARD, RUBBER, Surface


class Racket(NamedTuple):
    """An elliptic blade and where its centre sits in the body frame."""

    surface: Surface = CARDBOARD
    half_width: float = 0.075  # m, ITTF blade 0.150 m wide
    half_height: float = 0.0785  # m, 0.157 m tall
    x: float = 0.23
    y: float = 0.0
    z: float = 0.16


class Hull(NamedTuple):
    """A flat cylinder around the centre of mass: body, rotors and guard."""

    surface: Surface = Surface(0.3, 0.3)
    radius: float = 0.26
    half_height: float = 0.05


RACKETS = {"cardboard": Racket(CARDBOARD), "rubber": Racket(RUBBER)}
HULL = Hull()

HOME_BLADE = (-1.67, 0.0, 0.35)
"""Where the blade's centre hovers between serves, in the world frame."""

_RACKET = Racket()
HOME_BODY = (
    HOME_BLADE[0] - _RACKET.x,
    HOME_BLADE[1] - _RACKET.y,
    HOME_BLADE[2] - _RACKET.z,
)

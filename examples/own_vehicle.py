"""A drone of one's own: the simulator's vehicle with stronger loops, and what that is worth.

A vehicle is any object with the methods of `rotorpong.physics.vehicle.Vehicle`; here it is the
shipped one with other constants.
"""

from dataclasses import replace

from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.spec import Spec
from rotorpong.physics.vehicle import TUM_GAZEBO

BALLS = 40


def main() -> None:
    """Compare both drones on the same serves."""
    brisk = replace(
        TUM_GAZEBO,
        constants=TUM_GAZEBO.constants._replace(horizontal_p=8.0),
        name="brisk",
    )
    for vehicle in (TUM_GAZEBO, brisk):
        spec = Spec(player="paper", eyes="truth", vehicle=vehicle)
        result = summary(spec, evaluate(spec, BALLS))
        print(f"{result['vehicle']:12s} {result['hits']} hits of {result['balls']} balls")


if __name__ == "__main__":
    main()

"""
A drone of your own: other constants
====================================

A vehicle is any object with the methods of ``rotorpong.physics.vehicle.Vehicle``. Here it is the
simulator's own with stronger horizontal loops: how much faster it then follows a command, and what
that is worth to the paper's player.

Give it a name to keep the figure: ``python examples/own_vehicle.py step.png``.
"""

import sys
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from rotorpong.lab.evaluate import evaluate, summary
from rotorpong.lab.spec import Spec
from rotorpong.physics.vehicle import TICK, TUM_GAZEBO, Vehicle

plt.switch_backend("agg")  # a figure needs no display

BALLS = 40
BRISK = replace(TUM_GAZEBO, constants=TUM_GAZEBO.constants._replace(horizontal_p=8.0), name="brisk")
VEHICLES = (TUM_GAZEBO, BRISK)

# %%
# What a change does to the drone is seen in its answer to a step: 1 m/s to the left from hover.
# ``start`` and ``advance`` are all that it takes to fly a vehicle without a simulator.


def step_response(vehicle: Vehicle, ticks: int = 1200) -> np.ndarray:
    """Return the velocity to the left at every tick after 1 m/s is commanded."""
    state = vehicle.start(np.array([0.0, 0.0, 1.0]), np.random.default_rng(0))
    left = np.array([0.0, 1.0, 0.0, 0.0])
    _, track = vehicle.advance(state, left, ticks=ticks, new_command=True)
    return track.velocity[:, 1]


figure, axes = plt.subplots(figsize=(6.4, 3.4), layout="constrained")
for vehicle in VEHICLES:
    velocity = step_response(vehicle)
    axes.plot(np.arange(len(velocity)) * TICK, velocity, label=vehicle.name)
axes.axhline(1.0, color="grey", linewidth=0.8, linestyle="--", label="commanded")
axes.set(xlabel="time since the command, s", ylabel="velocity to the left, m/s")
axes.grid(alpha=0.3)
axes.legend()
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=150)

# %%
# Both drones meet the same serves.

for vehicle in VEHICLES:
    spec = Spec(player="paper", eyes="truth", vehicle=vehicle)
    result = summary(spec, evaluate(spec, BALLS))
    print(f"{result['vehicle']:12s} {result['hits']} hits of {result['balls']} balls")

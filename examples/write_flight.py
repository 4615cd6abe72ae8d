"""
A measured flight
=================

What a motion-capture system would write down of one ball: ``time_s,x_m,y_m,z_m``, z up. With such a
flight, measured or written, the simulator can throw the very same ball at any player::

    python examples/write_flight.py flight.csv
    rotorpong serves from-flight flight.csv --out serve.csv
    rotorpong evaluate --player paper --eyes paper --serves serve.csv --balls 10

``examples/flight.csv`` is such a flight. Without a name nothing is written.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.physics.ball import Air, Ball, fly

plt.switch_backend("agg")  # a figure needs no display

RATE = 120.0  # measurements per second
DURATION = 0.35  # s
NOISE = 0.003  # m, standard deviation on each axis

# %%
# A ball with some spin is thrown over the table, and each of its places is measured with noise.

rng = np.random.default_rng(0)
times = np.arange(0.0, DURATION, 1.0 / RATE)
ball = Ball(np.array([1.9, 0.1, 0.35]), np.array([-6.5, -0.2, 1.5]), np.array([0.0, 15.0, 10.0]))
path = np.array([fly(ball, Air(), time).position for time in times])
measured = path + rng.normal(0.0, NOISE, path.shape)

rows = [",".join(f"{number:.4f}" for number in row) for row in np.c_[times, measured]]
if len(sys.argv) > 1:
    Path(sys.argv[1]).write_text("\n".join(["time_s,x_m,y_m,z_m", *rows]) + "\n")
print(f"{len(rows)} measurements, the first at {rows[0]}")

# %%
# From the side, and how far each measurement is off.

figure, (side, off) = plt.subplots(
    2, figsize=(6.4, 5.0), height_ratios=(2, 1), layout="constrained"
)
side.plot(path[:, 0], path[:, 2], label="the ball")
side.plot(measured[:, 0], measured[:, 2], ".", markersize=4, label="measured")
side.axhline(BALL_RADIUS, color="grey", linewidth=0.8, linestyle="--", label="lying on the table")
side.set(xlabel="x, m: along the table, 0 at the net", ylabel="z, m")
side.set_aspect("equal")
side.legend()
off.plot(times, 1000.0 * (measured - path), ".", markersize=4, label=("x", "y", "z"))
off.set(xlabel="time, s", ylabel="off by, mm")
off.legend(ncols=3)
for axes in (side, off):
    axes.grid(alpha=0.3)

"""Write a flight as a motion-capture system would measure it: `time_s,x_m,y_m,z_m`, z up.

    python examples/write_flight.py [FLIGHT.csv]

`examples/flight.csv` was written by this file. `rotorpong serves from-flight` turns such a flight,
measured or written, into a serve that can be thrown at any player.
"""

import sys
from pathlib import Path

import numpy as np

from rotorpong.physics.ball import Air, Ball, fly

RATE = 120.0  # measurements per second
DURATION = 0.35  # s
NOISE = 0.003  # m, standard deviation on each axis


def main() -> None:
    """Throw one ball over the table, measure it, write it down."""
    rng = np.random.default_rng(0)
    times = np.arange(0.0, DURATION, 1.0 / RATE)
    ball = Ball(
        np.array([1.9, 0.1, 0.35]), np.array([-6.5, -0.2, 1.5]), np.array([0.0, 15.0, 10.0])
    )
    path = np.array([fly(ball, Air(), time).position for time in times])
    measured = path + rng.normal(0.0, NOISE, path.shape)
    rows = [",".join(f"{number:.4f}" for number in row) for row in np.c_[times, measured]]
    target = Path(sys.argv[1] if len(sys.argv) > 1 else "flight.csv")
    target.write_text("\n".join(["time_s,x_m,y_m,z_m", *rows]) + "\n")
    print(f"{len(rows)} measurements in {target}")


if __name__ == "__main__":
    main()

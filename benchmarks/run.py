"""Speed of the parts on one core: `./dev bench [NAME...]`.

Prints one JSON object per line, {"name", "value", "unit"}: medians over repetitions, after a
warm-up. Names that contain one of the given words are measured, all without. Set-up is not timed.
"""

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from statistics import median
from typing import Any

Measurement = tuple[Callable[[], Any], int, str]  # what to time, how many it does, its unit

WARM_UPS = 2
REPETITIONS = 15
RATES = {"frames/s", "flights/s", "steps/s"}  # larger is better; other units are durations
HOME_CAMERA = (-1.69, 0.0, 0.20)  # m, world: the camera of a drone at home
BALL = (-0.2, 0.1, 0.45)


def main() -> None:
    """Measure what the command line asks for."""
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"  # read when numpy is loaded, further down
    words = sys.argv[1:]
    chosen = {n: m for n, m in MEASUREMENTS.items() if not words or any(w in n for w in words)}
    if not chosen:
        sys.exit(f"no measurement is called {' or '.join(words)}: {', '.join(MEASUREMENTS)}")
    for name, make in chosen.items():
        work, count, unit = make()
        seconds = median(durations(work))
        value = count / seconds if unit in RATES else seconds / count * SCALES[unit]
        print(json.dumps({"name": name, "value": round(value, 6), "unit": unit}), flush=True)


def durations(work: Callable[[], Any]) -> Iterator[float]:
    """Yield how long each repetition of `work` took, in seconds."""
    for repetition in range(WARM_UPS + REPETITIONS):
        start = time.perf_counter()
        work()
        if repetition >= WARM_UPS:
            yield time.perf_counter() - start


def render_frames(camera_name: str) -> Measurement:
    """Render the court with the ball in view from home."""
    import numpy as np

    from rotorpong.conventions import CAMERA_FROM_BODY_AXES
    from rotorpong.physics.camera import CAMERAS
    from rotorpong.world.render import Scene, render

    camera, scene = CAMERAS[camera_name], Scene()
    pose = np.array(HOME_CAMERA), np.ascontiguousarray(CAMERA_FROM_BODY_AXES.T)
    ball = np.array(BALL)
    return lambda: render(camera, *pose, ball, scene), 1, "frames/s"


def detect_ball(camera_name: str) -> Measurement:
    """Search a whole rendered picture for the ball."""
    import cv2

    from rotorpong.vision.detect import detect

    cv2.setNumThreads(1)
    render_one, _, _ = render_frames(camera_name)
    picture = render_one()
    if not detect(picture):
        raise RuntimeError("the picture to be searched shows no ball")
    return lambda: detect(picture), 1, "ms"


def fly_balls() -> Measurement:
    """Fly many balls for a second each, without contacts."""
    import numpy as np

    from rotorpong.physics.ball import Air, Ball, fly

    rng, count = np.random.default_rng(0), 1000
    parts = [rng.normal(mean, sd, (count, 3)) for mean, sd in ((0, 0.3), (3, 2), (0, 20))]
    balls = Ball(*parts)
    return lambda: fly(balls, Air(), 1.0), count, "flights/s"


def roll_out_dmp() -> Measurement:
    """Roll out a primitive of three dimensions at 1 kHz, each time with another duration."""
    import numpy as np

    from rotorpong.primitives.dmp import State
    from rotorpong.primitives.fitting import fit_dmp

    rng = np.random.default_rng(0)
    times = np.linspace(0.0, 0.7, 22)
    dmp = fit_dmp(times, np.stack([np.sin(times), times**2, np.cos(2 * times)], axis=-1))
    start, goal = State(np.zeros(3), np.zeros(3)), State(np.ones(3), np.ones(3))

    def work() -> None:
        duration = rng.uniform(0.5, 0.9)
        dmp.roll_out(start, goal, duration, np.arange(0.0, duration, 0.001))

    return work, 1, "us"


def append_to_crkr(size: int = 1000) -> Measurement:
    """Append samples one by one from `size` on; six inputs, seven outputs."""
    import numpy as np

    from rotorpong.learning.crkr import CrKR

    rng = np.random.default_rng(0)
    inputs, labels = rng.normal(size=(size, 6)), rng.normal(size=(size, 7))
    model = CrKR(1.0, 0.1).fit(inputs, labels, rng.uniform(1.0, 20.0, size))

    def work() -> None:
        cost = rng.uniform(1.0, 20.0, 1)
        model.partial_fit(rng.normal(size=(1, 6)), rng.normal(size=(1, 7)), cost)

    return work, 1, "ms"


SCALES = {"ms": 1e3, "us": 1e6}
MEASUREMENTS: dict[str, Callable[[], Measurement]] = {
    "render 640x360": lambda: render_frames("gazebo"),
    "render 1280x720": lambda: render_frames("ardrone2_720p"),
    "detect 640x360": lambda: detect_ball("gazebo"),
    "detect 1280x720": lambda: detect_ball("ardrone2_720p"),
    "ball flights of 1 s": fly_balls,
    "dmp roll-out at 1 kHz": roll_out_dmp,
    "crkr append at N = 1000": append_to_crkr,
}


if __name__ == "__main__":
    main()

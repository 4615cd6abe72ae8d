"""Speed of the parts on one core: `./dev bench [WORD...]`.

Prints one JSON object per line, as the rows of `rotorpong bench`: medians over repetitions, after a
warm-up, CPU time. First what `rotorpong bench world` measures, then the parts that it does not
know. With words, only sections and parts whose names contain one of them are measured.
"""

import json
import os
import sys
from collections.abc import Callable
from typing import Any

HOME_CAMERA = (-1.69, 0.0, 0.20)  # m, world: the camera of a drone at home
BALL = (-0.2, 0.1, 0.45)

Part = tuple[Callable[[], Any], float, str]  # what to time, scale or count, unit


def main() -> None:
    """Measure what the command line asks for."""
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"  # read when numpy is loaded, further down
    words = sys.argv[1:]
    chosen = {name: part for name, part in PARTS.items() if _is_meant(name, words)}
    count = _print_world(words)
    for name, make in chosen.items():
        _print_part(name, *make())
    if not chosen and not count:
        sys.exit(f"nothing is called {' or '.join(words)}: {', '.join(PARTS)}")


def _is_meant(name: str, words: list[str]) -> bool:
    return not words or any(word in name for word in words)


def _print_world(words: list[str]) -> int:
    """Print the rows of `rotorpong bench world`; return how many sections there were."""
    from rotorpong.lab.bench.world import SECTIONS, Order

    order = Order()
    sections = [s for s in SECTIONS if s.asked(order) and _is_meant(s.title, words)]
    for section in sections:
        for row in section.rows(order, lambda *_: None):
            print(json.dumps(row.as_json()), flush=True)
    return len(sections)


def _print_part(name: str, work: Callable[[], Any], scale: float, unit: str) -> None:
    from rotorpong.lab.bench.rows import Row
    from rotorpong.lab.bench.timing import cpu_seconds

    seconds = cpu_seconds(work)
    value = scale / seconds if unit.endswith("/s") else seconds * scale
    print(json.dumps(Row(name, value, unit).as_json()), flush=True)


def render_frames(camera_name: str) -> Part:
    """Render the court with the ball in view from home."""
    import numpy as np

    from rotorpong.conventions import CAMERA_FROM_BODY_AXES
    from rotorpong.physics.camera import CAMERAS
    from rotorpong.world.render import Scene, render

    camera, scene = CAMERAS[camera_name], Scene()
    pose = np.array(HOME_CAMERA), np.ascontiguousarray(CAMERA_FROM_BODY_AXES.T)
    ball = np.array(BALL)
    return lambda: render(camera, *pose, ball, scene), 1.0, "frames/s"


def detect_ball(camera_name: str) -> Part:
    """Search a whole rendered picture for the ball, as the tracker does."""
    import cv2

    from rotorpong.vision.detect import find_balls

    cv2.setNumThreads(1)
    render_one, _, _ = render_frames(camera_name)
    picture = render_one()
    if not find_balls(picture):
        raise RuntimeError("the picture to be searched shows no ball")
    return lambda: find_balls(picture), 1e3, "ms"


def roll_out_dmp() -> Part:
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

    return work, 1e6, "us"


def append_to_crkr(size: int = 1000) -> Part:
    """Append samples one by one from `size` on; six inputs, seven outputs."""
    import numpy as np

    from rotorpong.learning.crkr import CrKR

    rng = np.random.default_rng(0)
    inputs, labels = rng.normal(size=(size, 6)), rng.normal(size=(size, 7))
    model = CrKR(1.0, 0.1).fit(inputs, labels, rng.uniform(1.0, 20.0, size))

    def work() -> None:
        cost = rng.uniform(1.0, 20.0, 1)
        model.partial_fit(rng.normal(size=(1, 6)), rng.normal(size=(1, 7)), cost)

    return work, 1e3, "ms"


PARTS: dict[str, Callable[[], Part]] = {
    "render 640x360": lambda: render_frames("gazebo"),
    "render 1280x720": lambda: render_frames("ardrone2_720p"),
    "detect 640x360": lambda: detect_ball("gazebo"),
    "detect 1280x720": lambda: detect_ball("ardrone2_720p"),
    "dmp roll-out at 1 kHz": roll_out_dmp,
    "crkr append at N = 1000": append_to_crkr,
}


if __name__ == "__main__":
    main()

"""crazyflow, in an environment of its own: steps per second with 1, 64 and 1024 worlds.

    python benchmarks/crazyflow_worlds.py FOLDER

Builds a virtual environment in FOLDER unless there is one (about 1.7 GB, from the network), then
measures there: crazyflow brings its own MuJoCo, which would overwrite that of this project's
environment without a word. Prints one JSON object per line, as the rows of `rotorpong bench`:
medians of CPU time over runs of 100 steps at 500 Hz, compilation apart.
"""

import os
import subprocess
import sys
import venv
from pathlib import Path

WORLDS = (1, 64, 1024)
PIN = "crazyflow==0.4.0"
MEASURE = """
import json, statistics, sys, time
import jax
import numpy as np
from crazyflow.control import Control
from crazyflow.sim import Sim

STEPS, REPETITIONS = 100, 7
for worlds in map(int, sys.argv[1:]):
    sim = Sim(n_worlds=worlds, n_drones=1, control=Control.attitude, freq=500, device="cpu")
    sim.reset()
    sim.attitude_control(np.tile([0.0, 0.0, 0.0, 0.4], (worlds, 1, 1)).astype(np.float32))
    durations = []
    for _ in range(2 + REPETITIONS):
        start = time.process_time()
        sim.step(STEPS)
        jax.block_until_ready(sim.data.states.pos)
        durations.append(time.process_time() - start)
    value = worlds * STEPS / statistics.median(durations[2:])
    row = {"name": f"crazyflow, {worlds} worlds", "value": value, "unit": "steps/s"}
    print(json.dumps(row), flush=True)
"""


def main() -> None:
    """Build what is missing and measure."""
    if len(sys.argv) != 2:
        sys.exit("usage: python benchmarks/crazyflow_worlds.py FOLDER")
    folder = Path(sys.argv[1]).absolute()
    python = folder / ("bin/python" if os.name == "posix" else "Scripts/python.exe")
    if not python.exists():
        venv.create(folder, with_pip=True)
    subprocess.run([python, "-m", "pip", "install", "--quiet", PIN], check=True)
    one_thread = {"OMP_NUM_THREADS": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
    environment = {**os.environ, **one_thread, "JAX_PLATFORMS": "cpu"}
    environment.pop("PYTHONPATH", None)
    command = [str(python), "-c", MEASURE, *map(str, WORLDS)]
    done = subprocess.run(command, env=environment, cwd=folder, check=False)  # its log stays there
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()

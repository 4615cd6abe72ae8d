"""After the warm-up nothing is left to compile: no worker, no timing pays for it."""

import subprocess
import sys

LEFT = """
import gc, importlib, pkgutil, sys, tempfile
from pathlib import Path

import rotorpong

for module in pkgutil.walk_packages(rotorpong.__path__, "rotorpong."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)

from numba.core.dispatcher import Dispatcher

from rotorpong.lab.evaluate import evaluate
from rotorpong.lab.serve_stats import serve_stats
from rotorpong.lab.spec import Spec
from rotorpong.lab.train import train
from rotorpong.lab.warmup import warm_up

ours = [d for d in gc.get_objects() if isinstance(d, Dispatcher)]
ours = [d for d in ours if d.py_func.__module__.startswith("rotorpong")]
warm_up(eyes="tracker")
before = {id(d): len(d.signatures) for d in ours}
evaluate(Spec(), 1)
evaluate(Spec("hover", camera="ardrone2_720p", serves="constant", racket="rubber"), 17)
serve_stats(Spec("hover"), 1)
evaluate(Spec(eyes="tracker"), 3)
train(Spec(eyes="truth", seed=1), 1, Path(tempfile.mkdtemp()) / "run.sqlite")
late = [d.py_func.__qualname__ for d in ours if len(d.signatures) != before[id(d)]]
print(sum(before.values()), late)
"""


def test_playing_training_and_statistics_compile_nothing_more():
    result = subprocess.run([sys.executable, "-c", LEFT], capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    signatures, late = result.stdout.split(maxsplit=1)
    assert int(signatures) > 10
    assert late.strip() == "[]"

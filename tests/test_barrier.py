"""A player cannot reach the simulator: importing all of its code never loads `rotorpong.world`.

import-linter reads imports from the source; this test sees those made by name as well.
"""

import functools
import subprocess
import sys

LOAD = """
import importlib, pkgutil, sys
for name in {names}:
    module = importlib.import_module("rotorpong." + name)
    for found in pkgutil.walk_packages(getattr(module, "__path__", ()), module.__name__ + "."):
        importlib.import_module(found.name)
print("\\n".join(sys.modules))
"""
PLAYER_SIDE = ("play", "vision", "primitives", "learning", "control", "drone")
WITHOUT_PICTURES = ("physics", "world", "primitives", "learning", "control", "experience")


@functools.cache
def modules_after_importing(*names):
    command = [sys.executable, "-c", LOAD.format(names=names)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout.split()


def parts_of(package, modules):
    return [name for name in modules if name == package or name.startswith(package + ".")]


def test_the_players_side_never_loads_the_simulator():
    modules = modules_after_importing(*PLAYER_SIDE)
    assert parts_of("rotorpong.world", modules) == []
    assert parts_of("rotorpong.lab", modules) == []


def test_the_players_side_never_loads_the_tables_of_truth():
    assert parts_of("rotorpong.experience.truth", modules_after_importing(*PLAYER_SIDE)) == []


def test_this_way_of_looking_does_find_the_simulator():
    modules = modules_after_importing("world")
    assert len(parts_of("rotorpong.world", modules)) > 1


def test_every_package_of_the_players_side_is_really_loaded():
    modules = modules_after_importing(*PLAYER_SIDE)
    assert [name for name in PLAYER_SIDE if not parts_of(f"rotorpong.{name}", modules)] == []


def test_physics_world_and_learning_run_without_opencv_and_matplotlib():
    modules = modules_after_importing(*WITHOUT_PICTURES)
    assert parts_of("cv2", modules) + parts_of("matplotlib", modules) == []

"""Gymnasium knows the environments, whichever is imported first, and nothing heavy is loaded."""

import subprocess
import sys

import pytest

NAMES = [f"rotorpong/{name}-v0" for name in ("Intercept", "InterceptVision", "Primitive")]
ORDERS = {
    "gymnasium first": "import gymnasium, rotorpong",
    "rotorpong first": "import rotorpong, gymnasium",
    "a part of rotorpong first": "import rotorpong.conventions, gymnasium",
    "a part of gymnasium": "import rotorpong; from gymnasium import spaces; import gymnasium",
    "looked for before it is loaded": (
        "import rotorpong, importlib.util as u\n"
        "u.find_spec('gymnasium'), u.find_spec('gymnasium')\n"
        "import gymnasium"
    ),
    "loaded twice": (
        "import sys, rotorpong, gymnasium\n"
        "for name in [m for m in sys.modules if m.startswith('gymnasium')]: del sys.modules[name]\n"
        "import importlib; import gymnasium; importlib.reload(rotorpong)"
    ),
}
HEAVY = ("gymnasium", "numpy", "numba", "cv2", "scipy", "matplotlib", "rotorpong.lab", "torch")


def said_by(code):
    command = [sys.executable, "-W", "error", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("order", ORDERS)
def test_all_environments_are_registered_in_any_order_of_import(order):
    code = "\nprint(*[name for name in gymnasium.registry if name.startswith('rotorpong/')])"
    assert said_by(ORDERS[order] + code) == NAMES


def test_an_environment_is_made_by_its_name_when_gymnasium_comes_later():
    code = (
        ORDERS["rotorpong first"]
        + f"""
for name in {NAMES}:
    print(gymnasium.make(name).spec.id)
print(gymnasium.make_vec(name, num_envs=2).num_envs)
"""
    )
    assert said_by(code) == [*NAMES, "2"]


def test_a_name_with_the_module_in_front_imports_it():
    code = f"""
import gymnasium
print(gymnasium.make("rotorpong:{NAMES[0]}").spec.id)
print(gymnasium.make_vec("rotorpong:{NAMES[0]}", num_envs=2).spec.id)
"""
    assert said_by(code) == NAMES[:1] * 2


def test_importing_the_package_loads_nothing_heavy():
    code = f"import sys, rotorpong; print(*[name for name in {HEAVY} if name in sys.modules])"
    assert said_by(code) == []


def test_registering_loads_nothing_of_the_environments():
    heavy = [name for name in HEAVY if name not in {"gymnasium", "numpy"}]
    code = f"import sys, rotorpong, gymnasium; print(*[m for m in {heavy} if m in sys.modules])"
    assert said_by(code) == []


def test_nothing_waits_any_longer_once_gymnasium_is_there():
    code = """
import sys
before = list(sys.meta_path)
import rotorpong
print(len(sys.meta_path) - len(before))
import gymnasium
print(len(sys.meta_path) - len(before))
"""
    assert said_by(code) == ["1", "0"]


def test_without_gymnasium_the_rest_works_and_the_error_is_pythons_own():
    code = """
import sys
import rotorpong
sys.path[:] = [path for path in sys.path if "site-packages" not in path]
try:
    import gymnasium
except ModuleNotFoundError as error:
    print(error.name)
"""
    assert said_by(code) == ["gymnasium"]

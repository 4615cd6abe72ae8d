"""The documentation's tables are those of the code."""

import inspect
import re
from pathlib import Path

import gymnasium
import pytest

import rotorpong
from rotorpong.lab.environments import intercept, intercept_vision, primitive
from rotorpong.lab.environments.arena import Game, arena
from rotorpong.lab.environments.spaces import Quantity, box, markdown

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "environments.md").read_text()
TABLES = {
    "intercept observation": intercept.OBSERVATION,
    "intercept action": intercept.ACTION,
    "navdata": intercept_vision.NAVDATA,
    "primitive observation": primitive.OBSERVATION,
    "primitive action": primitive.ACTION,
}


@pytest.mark.parametrize("quantities", TABLES.values(), ids=TABLES)
def test_every_number_of_a_space_is_documented_as_it_is(quantities):
    assert markdown(quantities) in PAGE


def test_every_environment_is_documented_and_every_documented_one_exists():
    named = set(re.findall(r"`(rotorpong/\w+-v\d+)`", PAGE))
    assert named == {name for name in gymnasium.registry if name.startswith("rotorpong/")}
    assert rotorpong.__version__


def test_every_argument_and_info_key_is_documented():
    env = gymnasium.make("rotorpong/Primitive-v0").unwrapped
    _, info = env.reset(seed=0)
    for name in (*info, *Game.__annotations__, "shaping", "render_mode", "eyes"):
        assert f"`{name}`" in PAGE


def test_every_default_is_documented_and_every_keyword_has_one():
    parameters = inspect.signature(arena).parameters
    assert set(parameters) == {*Game.__annotations__, "eyes"}
    for name, parameter in parameters.items():
        default = f'"{parameter.default}"' if type(parameter.default) is str else parameter.default
        assert f"| `{name}` | `{default}` |" in PAGE


def test_a_table_lists_name_unit_and_range():
    quantities = (Quantity("x_m", "m", -1.0, 2.0, "place"),)
    assert markdown(quantities).splitlines()[-1] == "| 0 | `x_m` | place | m | -1 | 2 |"
    space = box(quantities)
    assert (space.low.tolist(), space.high.tolist()) == ([-1.0], [2.0])

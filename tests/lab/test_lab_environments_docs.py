"""The documentation's tables are those of the code."""

import re
from pathlib import Path

import gymnasium
import pytest

import rotorpong
from rotorpong.lab.environments import intercept, intercept_vision, primitive
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
    arguments = ("vehicle", "camera", "serves", "racket", "purpose", "tell_reachable", "shaping")
    for name in (*info, *arguments, "eyes"):
        assert f"`{name}`" in PAGE


def test_a_table_lists_name_unit_and_range():
    quantities = (Quantity("x_m", "m", -1.0, 2.0, "place"),)
    assert markdown(quantities).splitlines()[-1] == "| 0 | `x_m` | place | m | -1 | 2 |"
    space = box(quantities)
    assert (space.low.tolist(), space.high.tolist()) == ([-1.0], [2.0])

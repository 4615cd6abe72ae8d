import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.lab.report.onlooker import seen_at
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.paper import fig1
from rotorpong.paper.findings import Scale
from rotorpong.paper.snapshot import as_rgb, as_text


@pytest.fixture(scope="module")
def answer():
    return fig1.picture(Spec("hover"), fig1.SERVE)


def is_orange(pixel):
    red, green, blue = (int(v) for v in pixel)
    return red > 1.3 * green > 1.3 * blue


def test_the_ball_is_where_it_is_0_2_s_before_it_arrives(answer):
    path = new_drone(stage_of(Spec("hover")), fig1.SERVE).truth().ball_path
    tick = round(1000.0 * answer["time_s"])
    np.testing.assert_array_equal(answer["ball_m"], path[tick])
    assert path[tick + 199, 0] >= -1.67 > path[tick + 200, 0]


def test_the_onlooker_sees_the_ball_there(answer):
    column, row = np.rint(seen_at(np.array(answer["ball_m"]))).astype(int)
    assert is_orange(as_rgb(answer["beside"])[row, column])


def test_the_onboard_picture_shows_a_ball(answer):
    pixels = as_rgb(answer["onboard"]).reshape(-1, 3)
    assert 50 < sum(is_orange(p) and p[0] > 150 and p[2] < 80 for p in pixels) < 5000


def test_findings_show_the_picture_with_its_setting_and_no_numbers(answer):
    found = fig1.findings(Scale(), {"picture": answer})
    assert list(found.figures) == ["fig1"]
    assert [*found.columns, *found.paper, *found.ours] == []
    assert found.setting["time"].startswith(f"{answer['time_s']:.3f} s")


def test_pictures_come_back_pixel_by_pixel_red_first():
    picture = np.random.default_rng(1).integers(0, 256, (7, 9, 3), np.uint8)
    np.testing.assert_array_equal(as_rgb(as_text(picture)), picture[..., ::-1])


@pytest.mark.parametrize("text", ["", "bm8gcGljdHVyZQ=="])
def test_what_is_no_picture_is_refused(text):
    with pytest.raises(InputError, match="PNG"):
        as_rgb(text)

import json
import re
from dataclasses import fields, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rotorpong.conventions import InputError
from rotorpong.physics.camera import ARDRONE2_360P, ARDRONE2_720P, LEAST_AND_MOST, Camera
from rotorpong.vision.calibration import SENSOR_FIELDS, read_camera

MINE = Camera("mine", 640, 360, (561.5, 562.25), (307.125, 190.5), (-0.5, 0.25, 5.5e-4, -1e-3, 0.0))
PLAIN = {
    "fx": 561.5,
    "fy": 562.25,
    "cx": 307.125,
    "cy": 190.5,
    "width": 640,
    "height": 360,
    "k1": -0.5,
    "k2": 0.25,
}
ROS = """\
# a comment
image_width: 640
image_height: 360
camera_name: mine
camera_matrix:
  rows: 3
  cols: 3
  data: [561.5, 0, 307.125, 0, 562.25, 190.5, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.5, 0.25, 5.5e-4,
   -1.e-03, 0]}
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
"""


def write_with_opencv(path, camera=MINE, coefficients=5, matrix=None, also=None):
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("calibration_time", "Mon 1 Jan 12:00:00")
    storage.write("image_width", camera.width_px)
    storage.write("image_height", camera.height_px)
    given_matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]]) if matrix is None else matrix
    storage.write("camera_matrix", given_matrix)
    distortion = np.array(camera.distortion + (0.0,) * 9)[:coefficients]
    storage.write("distortion_coefficients", distortion[:, None])
    storage.write("avg_reprojection_error", 0.25)
    for name, value in (also or {}).items():
        storage.write(name, np.array(value) if isinstance(value, tuple) else value)
    storage.release()
    return path


@pytest.mark.parametrize("suffix", ["yml", "yaml", "json"])
@pytest.mark.parametrize("coefficients", [4, 5, 8, 14])
def test_files_that_opencv_wrote_give_the_camera_that_went_in(tmp_path, suffix, coefficients):
    path = write_with_opencv(tmp_path / f"mine.{suffix}", coefficients=coefficients)
    assert read_camera(path) == MINE


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(
    st.tuples(*[st.floats(200.0, 2000.0)] * 2),
    st.tuples(st.floats(0.0, 640.0), st.floats(0.0, 360.0)),
)
def test_every_number_survives_the_way_through_opencvs_yaml(tmp_path, focal, center):
    camera = replace(MINE, focal_length_px=focal, center_px=center, distortion=(0.0,) * 5)
    read = read_camera(write_with_opencv(tmp_path / "mine.yml", camera))
    np.testing.assert_allclose(read.focal_length_px, focal, rtol=1e-14)
    np.testing.assert_allclose(read.center_px, center, rtol=1e-14)


def test_a_ros_camera_info_gives_the_same_camera(tmp_path):
    path = tmp_path / "front.yaml"
    path.write_text(ROS)
    assert read_camera(path) == MINE


def test_plain_json_gives_the_same_camera(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(PLAIN | {"p1": 5.5e-4, "p2": -1e-3}))
    assert read_camera(path) == MINE
    assert read_camera(str(path)) == MINE


SENSOR = {
    "frames_per_second": 25.0,
    "delay_s": (0.075, 0.13),
    "position_m": (0.2, 0.01, -0.02),
    "camera_pitch_deg": 15.0,
    "readout_s": 0.022,
    "exposure_s": 0.006,
    "blur_px": 0.6,
    "shot_noise": 0.14,
    "read_noise": 0.4,
    "gamma": 2.2,
    "jitter_s": 0.008,
    "drop_share": 0.01,
    "stream_mbit_s": 4.0,
}


def test_the_sensor_fields_are_all_that_a_camera_has_beside_its_lens():
    lens = {"name", "width_px", "height_px", "focal_length_px", "center_px", "distortion"}
    assert set(SENSOR) == set(SENSOR_FIELDS) == {field.name for field in fields(Camera)} - lens


def with_sensor(layout, folder):
    """Write the lens and all sensor fields in a layout; return the file."""
    path = folder / f"mine.{layout.partition(' ')[0]}"
    if layout == "json plain":
        path.write_text(json.dumps(PLAIN | {"p1": 5.5e-4, "p2": -1e-3} | SENSOR))
    elif layout == "yaml ros":
        rows = [
            f"{k}:\n- {v[0]}\n" + "".join(f"- {x}\n" for x in v[1:])
            if k == "delay_s"
            else f"{k}: {list(v) if isinstance(v, tuple) else f'{v}  # measured'}\n"
            for k, v in SENSOR.items()
        ]
        path.write_text(ROS + "".join(rows))
    else:
        write_with_opencv(path, also=SENSOR)
    return path


@pytest.mark.parametrize("layout", ["json plain", "yaml ros", "yml opencv", "json opencv"])
def test_every_layout_may_tell_the_sensor_and_the_place(tmp_path, layout):
    assert read_camera(with_sensor(layout, tmp_path)) == replace(MINE, **SENSOR)


def test_a_camera_that_is_written_down_flies_as_the_profile_it_is(tmp_path):
    page = (Path(__file__).resolve().parents[2] / "docs" / "cameras.md").read_text()
    (tmp_path / "mine.json").write_text(page.partition("```json\n")[2].partition("```")[0])
    assert read_camera(tmp_path / "mine.json") == replace(ARDRONE2_360P, name="my_drone")


def test_every_sensor_field_is_documented_with_its_default_and_its_range():
    page = (Path(__file__).resolve().parents[2] / "docs" / "cameras.md").read_text()
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| `")]
    told = {row[0].strip("`"): row[2:5] for row in rows}
    assert set(told) == set(SENSOR_FIELDS)
    for name, (default, least, most) in told.items():
        assert json.loads(default) == np.array(getattr(MINE, name)).tolist()
        if name in LEAST_AND_MOST:
            assert (float(least), float(most)) == LEAST_AND_MOST[name]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"gamma": 9}, "gamma is 9.0; expected 0.2 to 5"),
        ({"gamma": "video"}, "gamma is 'video'; expected a finite number"),
        ({"gamma": float("nan")}, "finite"),
        ({"shot_noise": -0.1}, "shot_noise is -0.1; expected 0 to 100"),
        ({"read_noise": True}, "finite"),
        ({"blur_px": 20}, "blur_px is 20.0; expected 0 to 2"),
        ({"drop_share": 1.0}, "drop_share is 1.0; expected 0 to 0.9"),
        ({"frames_per_second": 0}, "frames_per_second is 0.0; expected 1 to 1000"),
        ({"delay_s": [0.2, 0.1]}, "expected least and most"),
        ({"delay_s": 0.1}, "delay_s is 0.1; expected a list of 2 numbers"),
        ({"delay_s": [0.1]}, "expected a list of 2 numbers"),
        ({"delay_s": [0.1, "late"]}, "delay_s is 'late'; expected a finite number"),
        ({"delay_s": [75, 130]}, "0 to 10"),
        ({"position_m": [210, 0, 10]}, "metres, not millimetres"),
        ({"position_m": {"rows": 1, "cols": 2, "data": [0.2, 0.0]}}, "expected a list of 3"),
        ({"readout_s": 0.05}, "readout_s is 0.05; expected at most 0.03333"),
        ({"exposure_s": 0.02, "frames_per_second": 60}, "exposure_s is 0.02; expected at most"),
        ({"camera_pitch_deg": 91}, "camera_pitch_deg"),
        ({"gama": 2.2}, "unknown fields gama; known are fx.*gamma"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused_in_every_layout(tmp_path, change, says):
    (tmp_path / "plain.json").write_text(json.dumps(PLAIN | change))
    matrix = json.loads(write_with_opencv(tmp_path / "opencv.json").read_text())
    (tmp_path / "opencv.json").write_text(json.dumps(matrix | change))
    for name in ("plain.json", "opencv.json"):
        with pytest.raises(InputError) as error:
            read_camera(tmp_path / name)
        assert "\n" not in str(error.value)
        if name == "plain.json" or "gama" not in change:
            assert re.search(says, str(error.value))
        else:
            assert "unknown field gama; expected gamma" in str(error.value)


def test_the_real_drones_lens_can_be_undone_everywhere(tmp_path):
    read = read_camera(write_with_opencv(tmp_path / "drone.yml", ARDRONE2_720P))
    assert read.distortion == ARDRONE2_720P.distortion


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"fx": float("nan")}, "finite"),
        ({"fy": "wide"}, "finite"),
        ({"fx": None}, "finite"),
        ({"width": True}, "finite"),
        ({"width": 640.5}, "whole pixels"),
        ({"height": 0}, "whole pixels"),
        ({"fx": 3.6}, "millimetres"),
        ({"fx": -561.5}, "millimetres"),
        ({"cx": 900.0}, "outside the picture"),
        ({"k1": -3.0, "k2": 0.0}, "folds back"),
        ({"k1": 1e300}, "folds back"),
        ({"k9": 0.0}, "unknown fields k9"),
    ],
)
def test_numbers_that_are_no_camera_are_refused_with_the_reason(tmp_path, change, says):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(PLAIN | change))
    with pytest.raises(InputError, match=says) as error:
        read_camera(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("plumb_bob", "equidistant", "equidistant"),
        ("rows: 3\n  cols: 3\n  data: [561.5", "rows: 2\n  cols: 3\n  data: [561.5", "9 numbers"),
        ("[561.5, 0,", "[561.5, 2,", "fx 0 cx"),
        ("-0.5, 0.25, 5.5e-4,", "-0.5, 0.25,", "4 numbers"),
        ("image_width: 640\n", "", "lacks image_width"),
        ("image_width: 640", "image_width 640", "damaged YAML"),
        ("data: [561.5, 0", "data: [561.5, .nan", "damaged"),
    ],
)
def test_a_ros_file_with_one_thing_wrong_is_refused_with_the_reason(tmp_path, old, new, says):
    assert old in ROS
    path = tmp_path / "front.yaml"
    path.write_text(ROS.replace(old, new))
    with pytest.raises(InputError, match=says):
        read_camera(path)


def test_more_coefficients_than_the_model_has_are_refused_unless_zero(tmp_path):
    path = write_with_opencv(tmp_path / "mine.yml", coefficients=8)
    text = path.read_text()
    assert "0., 0., 0. ]" in text
    path.write_text(text.replace("0., 0., 0. ]", "0., 0., 0.01 ]"))
    with pytest.raises(InputError, match="any further ones 0"):
        read_camera(path)


def test_a_matrix_of_another_shape_is_refused(tmp_path):
    path = write_with_opencv(tmp_path / "mine.yml", matrix=np.eye(4))
    with pytest.raises(InputError, match="camera_matrix"):
        read_camera(path)


@pytest.mark.parametrize(
    "data", [b"", b"\xff\xfe\x00", b"{", b"[1, 2]", b"null", b"hello", b"\x00"]
)
def test_files_that_are_nothing_are_refused(tmp_path, data):
    path = tmp_path / "mine.yml"
    path.write_bytes(data)
    with pytest.raises(InputError):
        read_camera(path)


def test_missing_files_and_folders_are_refused(tmp_path):
    for path in (tmp_path, tmp_path / "nothing.yml"):
        with pytest.raises(InputError, match="calibration"):
            read_camera(path)


@settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.sampled_from(["yml", "json", "ros", "plain"]), st.data())
def test_damaged_bytes_give_a_camera_or_one_clear_error(tmp_path, layout, data):
    path = tmp_path / f"mine.{layout if layout in ('yml', 'json') else 'txt'}"
    if layout in ("yml", "json"):
        whole = write_with_opencv(path).read_bytes()
    else:
        whole = ROS.encode() if layout == "ros" else json.dumps(PLAIN).encode()
    at = data.draw(st.integers(0, len(whole)))
    cut = data.draw(st.integers(0, 30))
    path.write_bytes(whole[:at] + data.draw(st.binary(max_size=20)) + whole[at + cut :])
    camera = camera_or_complaint(path)
    if isinstance(camera, str):
        assert "\n" not in camera
    else:
        assert np.isfinite([*camera.focal_length_px, *camera.center_px, *camera.distortion]).all()


def camera_or_complaint(path):
    try:
        return read_camera(path)
    except InputError as error:
        return str(error)


def test_endless_nesting_is_refused(tmp_path):
    path = tmp_path / "deep.yml"
    for text in ("\n".join(" " * depth + "a:" for depth in range(2000)), "{" * 9999, "[" * 9999):
        path.write_text(text)
        with pytest.raises(InputError):
            read_camera(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (json.dumps(PLAIN | {"fx": 10**400}), "fx is '10000.*expected a finite number"),
        (json.dumps(PLAIN | {"fx": float("nan")}), "fx is 'nan'; expected a finite number"),
        (json.dumps(PLAIN | {"fx": -561.5}), "focal lengths .-561.5, 562.25. px"),
        (json.dumps(PLAIN | {"fx": [561.5]}), "fx is .*; expected a finite number"),
        (json.dumps(PLAIN | {"name": {"a": 1}}), "name is .*; expected text"),
        (json.dumps(PLAIN | {"name": 300 * "x"}), "expected text, up to 255 letters"),
        (json.dumps(PLAIN)[:-1] + ', "fx": 600}', "gives fx twice; expected each field once"),
        (json.dumps(PLAIN)[:-1] + ', "FX": 600}', "gives fx twice"),
        (ROS + "image_width: 1280\n", "gives image_width twice"),
        (ROS.replace("rows: 3", "rows: 9").replace("cols: 3", "cols: 1"), "0 0 1 as 3 x 3"),
        ("a: &a [1,1]\nb: &b [*a,*a]\nc: [*b,*b]\n", "damaged JSON|lacks fx"),
        (json.dumps(PLAIN | {"k" * 10**5: 1})[:-1] + "}", "unknown fields"),
        ('{"fx": ' + "9" * 5000 + "}", "is damaged JSON"),
        ("width: " * 10**5, "lacks fx"),
    ],
    ids=range(14),
)
def test_tricks_with_yaml_and_json_are_refused_with_the_reason(tmp_path, text, says):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=says):
        read_camera(path)


@pytest.mark.parametrize("text", [json.dumps(PLAIN, indent=1), ROS])
@pytest.mark.parametrize("change", [("\n", "\r\n"), ("", "\ufeff"), ("\n", "\n\n")])
def test_line_ends_and_byte_order_marks_of_other_systems_change_nothing(tmp_path, text, change):
    plain, other = tmp_path / "a.yaml", tmp_path / "b.yaml"
    plain.write_text(text)
    new = change[1] + text if not change[0] else text.replace(*change)
    other.write_bytes(new.encode())
    assert replace(read_camera(other), name="") == replace(read_camera(plain), name="")


def test_a_name_that_would_break_lines_or_terminals_is_made_printable(tmp_path):
    path = tmp_path / "camera.json"
    path.write_text(json.dumps(PLAIN | {"name": "a\nb\x1b[31m\ud800"}))
    assert read_camera(path).name == "a_b_[31m_"


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=8,
)


@settings(
    max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.dictionaries(st.sampled_from([*PLAIN, "name", *SENSOR_FIELDS]), values, max_size=3))
def test_any_value_in_any_field_gives_a_camera_or_one_clear_error(tmp_path, changes):
    path = tmp_path / "camera.json"
    path.write_text(json.dumps(PLAIN | changes))
    result = camera_or_complaint(path)
    if isinstance(result, Camera):
        assert np.isfinite([*result.focal_length_px, *result.center_px, *result.distortion]).all()
        assert result.name.isprintable()
    else:
        assert str(path) in result

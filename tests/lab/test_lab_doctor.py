"""The doctor finds this machine well, and says what is wrong where it is not."""

import json

import pytest

from rotorpong.conventions import RotorpongError
from rotorpong.lab import doctor
from rotorpong.lab.doctor import examine
from rotorpong.lab.tables import findings_table
from rotorpong.lab.warmup import STEPS, warm_up

NAMES = ["python", "packages", "kernel cache", "kernels", "demonstrations", "sight", "graphics"]


def test_this_machine_is_well_and_the_answer_is_json():
    told = []
    found = examine(progress=lambda *done: told.append(done))
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert [check["name"] for check in found["checks"]] == NAMES
    assert [check for check in found["checks"] if not check["ok"]] == []
    assert found["ok"] is True
    assert told == [(n, 7) for n in range(1, 8)]
    assert findings_table(found).row_count == 7


def test_what_is_wrong_is_named_and_the_rest_is_still_examined(monkeypatch):
    monkeypatch.setattr(doctor, "CACHE_FOLDER", None)
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-package"))
    found = examine()
    wrong = {check["name"]: check["found"] for check in found["checks"] if not check["ok"]}
    assert found["ok"] is False
    assert set(wrong) == {"packages", "kernel cache"}
    assert "no-such-package" in wrong["packages"]
    assert "set NUMBA_CACHE_DIR" in wrong["kernel cache"]


def test_a_graphics_library_would_be_noticed(monkeypatch):
    monkeypatch.setattr(doctor, "GRAPHICS", ("libc.so", "libGL."))
    with pytest.raises(RotorpongError, match=r"graphics libraries are loaded.*libc\.so"):
        doctor._graphics()


def test_clearing_the_cache_empties_it(monkeypatch, tmp_path):
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "old.nbi").touch()
    monkeypatch.setattr(doctor, "CACHE_FOLDER", folder)
    examine(clear_cache=True)
    assert list(folder.iterdir()) == []


def test_warming_up_tells_how_far_it_is():
    told = []
    warm_up(lambda *done: told.append(done))
    assert told == [(n, STEPS) for n in range(STEPS + 1)]

"""Compiled kernels are what the sources say, wherever and by whomever they run."""

import os
import shutil
import subprocess
import sys
from collections import namedtuple
from pathlib import Path

import pytest

from rotorpong import kernels

INNER = "from toy.kernels import kernel\n@kernel\ndef inner(x):\n    return x + {}\n"
OUTER = (
    "from toy.kernels import kernel\nfrom toy.inner import inner\n"
    "@kernel\ndef outer(x):\n    return 2 * inner(x)\n"
)
CALL = "from toy.outer import outer; print(outer(1))"


@pytest.fixture
def toy(tmp_path):
    """A package of two kernels in two files, under the product's own decorator."""
    package = tmp_path / "toy"
    package.mkdir()
    (package / "__init__.py").touch()
    shutil.copy(kernels.__file__, package / "kernels.py")
    (package / "inner.py").write_text(INNER.format(1))
    (package / "outer.py").write_text(OUTER)
    return package


def run(code, folder, **environment):
    places = {"NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": "", "HOME": str(folder)}
    command = [sys.executable, "-c", code]
    result = subprocess.run(
        command, cwd=folder, env={**os.environ, **places, **environment}, capture_output=True
    )
    assert result.returncode == 0, result.stderr.decode()
    return result.stdout.decode().strip()


def cached_folders(home):
    return sorted((home / ".cache" / "rotorpong").glob("kernels-*"))


def test_an_edited_callee_in_another_file_changes_the_result(toy):
    assert run(CALL, toy.parent) == "4"
    (toy / "inner.py").write_text(INNER.format(100))
    assert run(CALL, toy.parent) == "202"


def test_compiled_kernels_are_found_again_by_the_next_process(toy):
    count = "; print(sum(outer.stats.cache_hits.values()))"
    assert run(CALL + count, toy.parent).split() == ["4", "0"]
    assert run(CALL + count, toy.parent).split() == ["4", "1"]


def test_nothing_is_written_beside_the_sources(toy):
    run(CALL, toy.parent)
    assert not list(toy.rglob("*.nb?"))
    assert list(toy.parent.joinpath(".cache").rglob("*.nbc"))


def test_kernels_run_where_no_place_can_be_written(toy):
    nowhere = {"HOME": os.devnull, "XDG_CACHE_HOME": os.devnull, "NUMBA_CACHE_DIR": os.devnull}
    shown = run(
        CALL + "; from toy.kernels import CACHE_FOLDER as f; print(f)", toy.parent, **nowhere
    )
    assert shown.split() == ["4", "None"]


def test_caches_of_other_sources_go_when_they_were_long_unused(toy):
    run(CALL, toy.parent)
    (old,) = cached_folders(toy.parent)
    (toy / "inner.py").write_text(INNER.format(2))
    run(CALL, toy.parent)
    (recent,) = set(cached_folders(toy.parent)) - {old}
    os.utime(old, (0, 0))
    (toy / "inner.py").write_text(INNER.format(3))
    assert run(CALL, toy.parent) == "8"
    assert recent in cached_folders(toy.parent)
    assert old not in cached_folders(toy.parent)


def test_the_users_own_kernels_keep_their_cache_place():
    before = kernels.NUMBA_SETTINGS.CACHE_DIR
    kernels.kernel(lambda x: x)
    assert before == kernels.NUMBA_SETTINGS.CACHE_DIR


def test_a_kernel_under_a_wrapper_is_the_plain_function():
    def plain(x):
        return x + 1

    def wrapper(*_):
        raise AssertionError

    wrapper.__wrapped__ = plain
    assert kernels.kernel(wrapper)(1) == 2


def test_a_nearly_full_disk_gets_no_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    usage = namedtuple("usage", "total used free")
    assert kernels.cache_root() == tmp_path / "rotorpong"
    short = usage(1, 1, kernels.MINIMUM_FREE_BYTES - 1)
    monkeypatch.setattr(kernels.shutil, "disk_usage", lambda _: short)
    assert kernels.cache_root() is None


def test_a_place_that_cannot_be_a_folder_is_passed_over(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert kernels.cache_root() == tmp_path / "rotorpong"


def test_a_home_that_does_not_exist_is_not_created(monkeypatch, tmp_path):
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "nobody"))
    assert kernels.cache_root() is None
    assert not Path(tmp_path / "nobody").exists()

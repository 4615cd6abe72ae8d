"""The folder of a demo: what may be in it, and how its files are replaced.

Everything is made in a hidden folder beside the files of the last demo and put in their place when
it is finished, so a demo that breaks off leaves what was there before. Files of these names that
are not a demo's are never replaced; files of other names are left alone.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from rotorpong.conventions import InputError, RotorpongError, StoreError
from rotorpong.experience import open_store
from rotorpong.experience.shipped import read_demonstrations
from rotorpong.files import prepare_folder, put, target_of
from rotorpong.lab.report import GENERATOR

DEMONSTRATIONS, EXPERIENCE = "demonstrations.json", "experience.sqlite"
RESULTS, REPORT = "results.json", "report.html"
FILES = (DEMONSTRATIONS, EXPERIENCE, RESULTS, REPORT)
LOGS = ("-wal", "-shm")  # of an older experience: they would be folded into the new one


@contextmanager
def finished_together(out: Path) -> Iterator[Path]:
    """Give a folder to work in; at the end its files are put into `out`, or, after an error, none.

    Raises:
        InputError: `out` is a file, cannot be written, or holds another's file of these names.
    """
    _prepare(out)
    with TemporaryDirectory(prefix=".demo-", suffix=".part", dir=out) as draft:
        with _blaming(out, Path(draft)):
            yield Path(draft)
        for end in LOGS:
            (out / (EXPERIENCE + end)).unlink(missing_ok=True)
        for name in FILES:
            put(Path(draft) / name, out / name)


@contextmanager
def _blaming(out: Path, draft: Path) -> Iterator[None]:
    """Let errors name the folder that was asked for, not the hidden one."""
    try:
        yield
    except RotorpongError as error:
        raise type(error)(str(error).replace(str(draft), str(out))) from error
    except OSError as error:
        raise InputError(f"{out}: cannot be written ({error.strerror or error})") from error


def _prepare(out: Path) -> None:
    """Make the folder; refuse what a demo must not touch."""
    prepare_folder(out)
    for name, is_ours in CHECKS.items():
        target_of(out / name)
        if (out / name).exists() and not is_ours(out / name):
            raise InputError(
                f"{out / name}: not written by a demo of this version; "
                "expected a folder without it: remove it or choose another"
            )


def _is_experience(path: Path) -> bool:
    try:
        open_store(path, readonly=True).close()
    except StoreError:
        return False
    return True


def _are_demonstrations(path: Path) -> bool:
    try:
        read_demonstrations(path)
    except StoreError:
        return False
    return True


def _are_results(path: Path) -> bool:
    try:
        content = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(content, dict) and "rotorpong" in content


def _is_report(path: Path) -> bool:
    try:
        return GENERATOR in path.read_text("utf-8")
    except (OSError, ValueError):
        return False


CHECKS = {
    DEMONSTRATIONS: _are_demonstrations,
    EXPERIENCE: _is_experience,
    RESULTS: _are_results,
    REPORT: _is_report,
}

"""Peers: what other people's programs need for the same work, measured in the same run.

Their adapters lie in `benchmarks/peers/` of a checkout, one file each with `require()`, which
raises ImportError while the peer is not installed, and `rows(*, quick)`. `SUITE` names the suite
that an adapter belongs to, if it is not `bench world`.
"""

import importlib.util
from pathlib import Path
from types import ModuleType

import rotorpong
from rotorpong.conventions import InputError
from rotorpong.lab.bench.rows import Row

FOLDER = Path(rotorpong.__file__).resolve().parents[2] / "benchmarks" / "peers"


def require(folder: Path = FOLDER, *, suite: str = "world") -> None:
    """See that every peer of a suite can be measured.

    Raises:
        InputError: this is no checkout, or the extra `bench` is not installed.
    """
    for adapter in _adapters(folder, suite):
        try:
            adapter.require()
        except ImportError as error:
            raise InputError(
                f"--peers: {error}; expected the extra bench: pip install -e .[bench]"
            ) from error


def rows(*, quick: bool = False, folder: Path = FOLDER, suite: str = "world") -> tuple[Row, ...]:
    """Measure all peers of a suite and return the rows."""
    return tuple(row for adapter in _adapters(folder, suite) for row in adapter.rows(quick=quick))


def _adapters(folder: Path, suite: str) -> list[ModuleType]:
    files = sorted(folder.glob("[!_]*.py"))
    if not files:
        raise InputError(f"--peers: no adapters in {folder}; expected a checkout of the sources")
    loaded = [_loaded(file) for file in files]
    return [adapter for adapter in loaded if getattr(adapter, "SUITE", "world") == suite]


def _loaded(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"rotorpong_peer_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise InputError(f"--peers: {file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module

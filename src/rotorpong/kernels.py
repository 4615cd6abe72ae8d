"""One decorator for every numba kernel.

numba keys its cache by the file of the kernel alone, so an edited callee or constant in another
file silently keeps its old value. Here the cache lives in a folder named by a hash of all sources
that a kernel can depend on. It is outside the package, which may be read-only and must leave
nothing behind when it is uninstalled. Where nothing is writable, or the disk is nearly full,
kernels compile uncached.
"""

import contextlib
import hashlib
import inspect
import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import config

NUMBA_SETTINGS: Any = config
MINIMUM_FREE_BYTES = 100 * 2**20  # a truncated cache file breaks every later run
NO_KERNEL_BELOW = frozenset(  # upper layers: no kernel lies in them or depends on them
    {"__main__.py", "cli", "paper", "lab", "play", "experience", "drone.py"}
)
KEEP_UNUSED_S = 2 * 24 * 3600.0  # caches of other sources go when they were not used for so long


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` with numba on its first call, cached across runs.

    The function is unwrapped first: a type-checking import hook puts a closure around it that
    numba can neither compile nor cache.
    """
    return _compiled(function)


def inlined_kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` as `kernel` does, and into each kernel that calls it.

    A loop over lanes becomes vector instructions only where nothing in it is called or raised: here
    a division by zero gives inf or nan, in a `kernel` it raises.
    """
    return _compiled(function, forceinline=True, error_model="numpy")


def spliced_kernel(function: Callable[..., Any]) -> Any:
    """Make `function` a piece of source that numba puts into the kernels that call it.

    It is not compiled by itself, which saves what compiling it would take, and arrays that it is
    handed are not counted. For what is called from one place, and large.
    """
    return numba.njit(inline="always")(inspect.unwrap(function))


def _compiled(function: Callable[..., Any], **options: Any) -> Any:
    plain = inspect.unwrap(function)
    if CACHE_FOLDER is None:
        return numba.njit(**options)(plain)
    before = NUMBA_SETTINGS.CACHE_DIR  # put back after: users' own kernels keep their cache
    NUMBA_SETTINGS.CACHE_DIR = str(CACHE_FOLDER)
    try:
        return numba.njit(cache=True, **options)(plain)
    finally:
        NUMBA_SETTINGS.CACHE_DIR = before


def cache_root() -> Path | None:
    """Return the first place for caches that can be written, `None` if there is none.

    Never a shared temporary folder: a cache is code, and others could put theirs there.
    """
    for base in _candidates():
        folder = base / "rotorpong"
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError:
            continue
        if shutil.disk_usage(folder).free >= MINIMUM_FREE_BYTES:
            return folder
    return None


def _candidates() -> list[Path]:
    named = [os.environ.get("NUMBA_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")]
    places = [Path(name).absolute() for name in named if name]
    with contextlib.suppress(RuntimeError):  # no home: a service account
        if Path.home().is_dir():
            places.append(Path.home() / ".cache")
    return places


def _cache_folder() -> Path | None:
    root = cache_root()
    if root is None:
        return None
    folder = root / f"kernels-{_hash_of_sources(Path(__file__).parent)}"
    try:
        is_new = not folder.exists()
        folder.mkdir(mode=0o700, exist_ok=True)
        os.utime(folder)
    except OSError:
        return None
    if is_new:
        _forget_unused(root, newest=folder)
    return folder


def _hash_of_sources(package: Path) -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for path in sorted(package.rglob("*.py")):
        place = path.relative_to(package)
        if place.parts[0] not in NO_KERNEL_BELOW:
            digest.update(str(place).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _forget_unused(root: Path, *, newest: Path) -> None:
    now = newest.stat().st_mtime
    for folder in root.glob("kernels-*"):
        with contextlib.suppress(OSError):  # another process may be faster
            if now - folder.stat().st_mtime > KEEP_UNUSED_S:
                shutil.rmtree(folder, ignore_errors=True)


CACHE_FOLDER = _cache_folder()

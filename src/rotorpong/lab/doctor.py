"""Does rotorpong work on this machine: versions, compiled kernels, one rendered and seen ball."""

import importlib.metadata
import platform
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rotorpong import __version__
from rotorpong.conventions import RotorpongError
from rotorpong.experience import shipped_demonstrations
from rotorpong.kernels import CACHE_FOLDER
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.lab.warmup import warm_up
from rotorpong.vision import detect

PACKAGES = ("numpy", "scipy", "numba", "opencv-python-headless", "matplotlib", "tyro", "rich")
GRAPHICS = ("libGL.", "libGLX", "libEGL", "libOSMesa", "libX11", "libvulkan", "libgbm", "libQt")
SEEN_FRAMES = 10


def examine(
    *, clear_cache: bool = False, progress: Callable[[int, int], None] | None = None
) -> dict[str, Any]:
    """Return what `doctor --json` prints: `ok`, and a list of `{name, ok, found}`."""
    if clear_cache and CACHE_FOLDER is not None:
        shutil.rmtree(CACHE_FOLDER, ignore_errors=True)
        CACHE_FOLDER.mkdir(mode=0o700, parents=True, exist_ok=True)
    examinations = (_python, _packages, _kernel_cache, _kernels, _demonstrations, _sight, _graphics)
    checks = []
    for done, examination in enumerate(examinations, start=1):
        checks.append(_checked(examination))
        if progress is not None:
            progress(done, len(examinations))
    return {"version": __version__, "ok": all(check["ok"] for check in checks), "checks": checks}


def _checked(examination: Callable[[], str]) -> dict[str, Any]:
    name = examination.__name__.strip("_").replace("_", " ")
    try:
        return {"name": name, "ok": True, "found": examination()}
    except (RotorpongError, OSError, ImportError) as error:
        return {"name": name, "ok": False, "found": str(error)}


def _python() -> str:
    return f"{platform.python_version()} on {platform.system()} {platform.machine()}"


def _packages() -> str:
    return ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)


def _kernel_cache() -> str:
    if CACHE_FOLDER is None:
        raise RotorpongError(
            "no writable place with 100 MB free for compiled kernels, so every start compiles for "
            "a minute: set NUMBA_CACHE_DIR to one"
        )
    free = shutil.disk_usage(CACHE_FOLDER).free
    return f"{CACHE_FOLDER}, {free / 2**30:.1f} GB free"


def _kernels() -> str:
    warm_up()
    return "compiled"


def _demonstrations() -> str:
    shown = shipped_demonstrations()
    return f"{len(shown)} of the {shown[0].pilot} pilot"


def _sight() -> str:
    drone = new_drone(stage_of(Spec()), 0)
    observations = [drone.observe() for _ in range(SEEN_FRAMES)]
    last = observations[-1]
    balls = detect(last.frame.picture) if last is not None else []
    if not balls:
        raise RotorpongError("the ball of a rendered frame was not found")
    return f"ball of {balls[0].diameter_px:.1f} px found in a rendered frame"


def _graphics() -> str:
    maps = Path("/proc/self/maps")
    if sys.platform != "linux" or not maps.exists():
        return "not examined here"
    loaded = sorted({name for name in GRAPHICS if name in maps.read_text()})
    if loaded:
        raise RotorpongError(f"graphics libraries are loaded that nothing needs: {loaded}")
    return "no OpenGL, no display needed"

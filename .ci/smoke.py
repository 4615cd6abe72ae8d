"""The installed wheel plays, sees and learns outside the repository, without GL, display, network.

usage: hide_gl.sh PYTHON smoke.py REPOSITORY      (PYTHON: of the environment with the wheel)
"""

import ctypes
import json
import subprocess
import sys
from pathlib import Path

import rotorpong
from rotorpong.experience.shipped import shipped_demonstrations

COMMAND = [str(Path(sys.executable).with_name("rotorpong"))]
GL = ("libGL.so.1", "libEGL.so.1", "libX11.so.6")


def main() -> None:
    """Check the surroundings, the package's files, then the commands."""
    repository = Path(sys.argv[1]).resolve()
    expect("GL is hidden", not any(can_load(library) for library in GL))
    expect("there is no network", network_interfaces() <= {"lo"})
    expect("the wheel is used", repository not in Path(rotorpong.__file__).resolve().parents)
    expect("ten demonstrations ship", len(shipped_demonstrations()) == 10)
    expect("help is shown", "evaluate" in run("--help").stdout)
    for player, eyes in (("hover", "truth"), ("paper", "paper")):
        serve = ("evaluate", "--player", player, "--eyes", eyes, "--balls", "4", "--seed", "1")
        expect(f"{player} plays with {eyes} eyes", len(json_of(*serve, "--json")["trials"]) == 4)
    first, again = (run(*serve, "--json").stdout for _ in range(2))
    expect("the same command gives the same answer", first == again)
    expect("serves have statistics", json_of("serves", "stats", "--json"))
    expect("bad input is exit 2 and one line", is_refused("evaluate", "--balls", "-1"))


def expect(what: str, holds: object) -> None:
    """Print what holds; leave with an error if it does not."""
    print(("ok   " if holds else "FAIL ") + what, flush=True)
    if not holds:
        sys.exit(1)


def can_load(library: str) -> bool:
    """Tell whether the dynamic linker finds a library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def network_interfaces() -> set[str]:
    """Return the names of all network interfaces."""
    lines = Path("/proc/net/dev").read_text().splitlines()[2:]
    return {line.partition(":")[0].strip() for line in lines}


def run(*arguments: str, code: int = 0) -> "subprocess.CompletedProcess[str]":
    """Run `rotorpong` with arguments; leave if it does not end with `code`."""
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != code:
        sys.stderr.write(done.stdout + done.stderr)
        expect(
            f"rotorpong {' '.join(arguments)} ends with {code}, not {done.returncode}", holds=False
        )
    return done


def json_of(*arguments: str) -> dict[str, list[object]]:
    """Return what a command prints, which must be one line of JSON."""
    (line,) = run(*arguments).stdout.splitlines()
    return json.loads(line)


def is_refused(*arguments: str) -> bool:
    """Tell whether bad input is answered by exit 2, one line on stderr and nothing on stdout."""
    done = run(*arguments, code=2)
    return len(done.stderr.splitlines()) == 1 and not done.stdout


if __name__ == "__main__":
    main()

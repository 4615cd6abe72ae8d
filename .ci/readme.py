"""Run every `rotorpong` command and every example of a page, in order, where it is called.

usage: readme.py README.md

Commands are the lines of ```sh blocks that start with `rotorpong` or `python examples/`. The first
that fails ends it.
"""

import re
import subprocess
import sys
import time
from pathlib import Path


def main() -> None:
    """Run the commands of the page named on the command line."""
    commands = commands_of(Path(sys.argv[1]).read_text())
    if not commands:
        sys.exit(f"{sys.argv[1]}: no command found")
    for command in commands:
        start = time.monotonic()
        done = subprocess.run(command, shell=True, stdout=subprocess.DEVNULL, check=False)
        print(f"exit {done.returncode} {time.monotonic() - start:6.1f} s  {command}", flush=True)
        if done.returncode:
            sys.exit(1)


def commands_of(page: str) -> list[str]:
    """Return the commands of a page without their trailing comments."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page, re.M | re.S)
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    started = [line for line in lines if line.startswith(("rotorpong", "python examples/"))]
    return [line.partition("  #")[0].strip() for line in started]


if __name__ == "__main__":
    main()

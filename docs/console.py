"""Keep the commands of a page true: run them, and write what they print beneath them.

    python docs/console.py docs/start.md

A command is a line of a console block that begins with `$ rotorpong`. All of a page run in one
folder, in order, with `examples` beside them. What other commands print is left as it is.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
WIDTH = "88"  # columns of the terminal: what fits beside the contents
BLOCK = re.compile(r"(?<=^```console\n).*?(?=^```$)", re.M | re.S)
COMMAND = re.compile(r"^\$ (.*(?:(?<=\\)\n.*)*)\n((?:(?!\$ ).*\n)*)", re.M)


def main() -> None:
    """Bring the pages named on the command line up to date."""
    for page in map(Path, sys.argv[1:]):
        page.write_text(refreshed(page.read_text()))


def refreshed(page: str) -> str:
    """Return the text of a page with what its commands print now."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "examples").symlink_to(REPOSITORY / "examples")
        return BLOCK.sub(lambda block: COMMAND.sub(lambda c: shown(c, folder), block[0]), page)


def shown(found: re.Match[str], folder: str) -> str:
    """Return a command and what it prints."""
    command, printed = found.groups()
    if command.startswith("rotorpong "):
        printed = "".join(f"{line.rstrip()}\n" for line in run(command, folder).splitlines())
    return f"$ {command}\n{printed}"


def run(command: str, folder: str) -> str:
    """Run a command in a folder; return what it prints, except into a file.

    Raises:
        SystemExit: it failed.
    """
    words, _, kept = command.replace("\\\n", " ").partition(" > ")
    done = subprocess.run(
        [sys.executable, "-m", *shlex.split(words)],
        cwd=folder,
        env={**os.environ, "COLUMNS": WIDTH},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"{command}\n{done.stdout}{done.stderr}")
    if kept:
        (Path(folder) / kept).write_text(done.stdout)
    return done.stderr if kept else done.stdout + done.stderr


if __name__ == "__main__":
    main()

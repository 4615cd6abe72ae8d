"""The command line: arguments -> calls.

Every command takes `--json` (stdout then carries one JSON object on one line and nothing else) and
`--seed`. Exit status: 0 success, 2 bad input with one line on stderr, 130 Ctrl-C, 1 a doctor that
found a problem. Progress goes to
stderr. What is heavy is imported by the command that needs it, so that `--help` is quick.
"""

import contextlib
import io
import json
import logging
import os
import re
import signal
import sys
from typing import Annotated, Any, NoReturn

import tyro
from tyro.conf import subcommand

from rotorpong.cli.common import say
from rotorpong.cli.look import Detect, Doctor, Serves
from rotorpong.cli.play import Demo, Evaluate, Train

BAD_INPUT = 2
INTERRUPTED = 130
UNFIT = 1  # doctor found a problem


Command = (
    Annotated[Demo, subcommand("demo")]
    | Annotated[Train, subcommand("train")]
    | Annotated[Evaluate, subcommand("evaluate")]
    | Annotated[Detect, subcommand("detect")]
    | Annotated[Serves, subcommand("serves")]
    | Annotated[Doctor, subcommand("doctor")]
)


def main() -> NoReturn:
    """Run one command and exit."""
    logging.basicConfig(format="rotorpong: %(message)s")
    try:
        status = _run(sys.argv[1:])
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is left is only tidying up
        say("interrupted")
        status = INTERRUPTED
    sys.exit(status)


def _run(arguments: list[str]) -> int:
    from rotorpong.conventions import RotorpongError, require_seed

    command = _parsed(arguments)
    try:
        require_seed(command.seed)
        with contextlib.redirect_stdout(sys.stderr) if command.json else contextlib.nullcontext():
            result = command.run()
        if command.json:
            print(json.dumps(result, allow_nan=False), flush=True)  # noqa: T201
        return 0 if result.get("ok", True) else UNFIT
    except BrokenPipeError:  # whoever read stdout had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (RotorpongError, OSError) as error:
        say(" ".join(str(error).split()))
        return BAD_INPUT
    return 0


def _parsed(arguments: list[str]) -> Any:
    """Parse; where tyro would print a box, print one line."""
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box):
            return tyro.cli(
                Command,  # pyright: ignore[reportArgumentType]
                prog="rotorpong",
                args=arguments or ["--help"],
                description="A quadrotor that learns to play table tennis with one onboard camera.",
            )
    except SystemExit as exit_:
        if exit_.code not in (0, None):
            say(_one_line(box.getvalue()))
            sys.exit(BAD_INPUT)
        raise


def _one_line(box: str) -> str:
    """Return the words of a box of text, its parts divided by semicolons."""
    plain = re.sub(r"\x1b\[[0-9;]*m", "", box)
    parts = re.split(r"[─-]{3,}", re.sub(r"[│╭╮╰╯┌┐└┘├┤]", " ", plain))
    title, *said = [" ".join(part.split()) for part in parts if part.strip("─ \n")]
    return "; ".join(said or [title])

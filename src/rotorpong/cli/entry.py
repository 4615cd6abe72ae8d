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

from rotorpong import __version__
from rotorpong.cli.bench import Bench
from rotorpong.cli.calibrate import Calibrate
from rotorpong.cli.common import say
from rotorpong.cli.look import Detect, Doctor, Serves
from rotorpong.cli.play import Demo, Evaluate, Train
from rotorpong.cli.predict import Predict
from rotorpong.cli.reproduce import Reproduce
from rotorpong.cli.suite import Suite
from rotorpong.cli.throw import Throw

BAD_INPUT = 2
INTERRUPTED = 130
UNFIT = 1  # doctor found a problem
ABOUT = (
    "A quadrotor that learns to play table tennis with one onboard camera. "
    "rotorpong --version tells which version this is."
)


Command = (
    Annotated[Demo, subcommand("demo")]
    | Annotated[Train, subcommand("train")]
    | Annotated[Evaluate, subcommand("evaluate")]
    | Annotated[Suite, subcommand("suite")]
    | Annotated[Detect, subcommand("detect")]
    | Annotated[Calibrate, subcommand("calibrate")]
    | Annotated[Serves, subcommand("serves")]
    | Annotated[Predict, subcommand("predict")]
    | Annotated[Throw, subcommand("throw")]
    | Annotated[Bench, subcommand("bench")]
    | Annotated[Reproduce, subcommand("reproduce")]
    | Annotated[Doctor, subcommand("doctor")]
)


def main() -> NoReturn:
    """Run one command and exit."""
    logging.basicConfig(format="rotorpong: %(message)s")
    if sys.argv[1:2] in (["bench"], ["reproduce"]):
        _start_again_with_one_thread()
    try:
        status = _run(sys.argv[1:])
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is left is only tidying up
        say("interrupted")
        status = INTERRUPTED
    sys.exit(status)


def _run(arguments: list[str]) -> int:
    if arguments == ["--version"]:
        print(f"rotorpong {__version__}")  # noqa: T201
        return 0
    command = _parsed(arguments)
    from rotorpong.conventions import RotorpongError, one_line, require_seed

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
        say(one_line(error))
        return BAD_INPUT
    return 0


def _start_again_with_one_thread() -> None:
    """Become the same command with one thread for every numeric library.

    They read their thread counts when they are loaded, and by now they may be.
    """
    from rotorpong.lab.bench.timing import is_single_thread, single_thread

    if is_single_thread() or os.name != "posix":
        return
    environment = dict(os.environ)
    single_thread(environment)
    os.execve(sys.executable, [sys.executable, "-m", "rotorpong", *sys.argv[1:]], environment)


def _parsed(arguments: list[str]) -> Any:
    """Parse; where tyro would print a box, print one line."""
    box = io.StringIO()
    try:
        with contextlib.redirect_stderr(box):
            return tyro.cli(
                Command,  # pyright: ignore[reportArgumentType]
                prog="rotorpong",
                args=arguments or ["--help"],
                description=ABOUT,
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

"""The frozen benchmark: suite."""

import shlex
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal

from tyro.conf import Fixed, FlagCreatePairsOff, Positional, Suppress

from rotorpong.cli.common import (
    Match,
    compile_kernels,
    knowledge_of,
    progress_bar,
    say,
    show,
    within_cores,
)

LEFT_OUT = ("what", "seed", "json", "out", "resume", "workers")  # that no result depends on
ALWAYS = ("player", "eyes")


@dataclass(frozen=True, kw_only=True)
class Suite(Match):
    """Measure a player on a frozen benchmark, for leaderboards; it never learns here.

    Serves, vehicles, cameras and seeds are given. Skill is 0 for a drone that only hovers and 1 for
    the oracle; the score is its mean over the cells.
    """

    what: Positional[Literal["v1"]]
    """v1: 7 cells of 300 balls each."""

    vehicle: Suppress[Fixed[str]] = "tum_gazebo"
    camera: Suppress[Fixed[str]] = "gazebo"
    serves: Suppress[Fixed[str]] = "human"
    ball: Suppress[Fixed[str]] = "orange"
    seed: int = 0
    """Taken by every command; a suite's seeds are fixed, so nothing but 0 is accepted."""

    experience: Path | None = None
    """What players nearest, single, paper and bandit start from: a file of `train`. Default: ten
    scripted demonstrations. The result tells which."""
    quick: FlagCreatePairsOff[bool] = False
    """The first twenty balls of each cell: compares with nothing, and no leaderboard takes it."""
    out: Path | None = None
    """FILE.json for the result; until it is whole, FILE.json.part holds the cells that are done."""
    resume: FlagCreatePairsOff[bool] = False
    """Go on with FILE.json.part of a run that was interrupted."""
    workers: int = 1
    """Processes, at most one for each core; the results do not depend on it."""

    def run(self) -> dict[str, Any]:
        """Play the suite."""
        from rotorpong.lab.spec import require_count
        from rotorpong.lab.suite.cells import SUITES
        from rotorpong.lab.suite.kept import Kept
        from rotorpong.lab.suite.playing import play_suite
        from rotorpong.lab.suite.tables import suite_table

        require_count("workers", self.workers)
        suite = SUITES[self.what]
        self._check()
        entrant = self._entrant().check(suite)
        kept = None if self.out is None else Kept(self.out, self.resume).check()
        compile_kernels(self.eyes)
        with progress_bar() as advance:
            found = play_suite(
                suite,
                entrant,
                quick=self.quick,
                workers=within_cores(self.workers),
                kept=kept,
                progress=advance,
            )
        result = {"command": self.command(), **found}
        if kept is not None:
            kept.finish(result)
        if not self.json:
            show(suite_table(result))
            if self.out is not None:
                say(f"result: {self.out}")
        return result

    def command(self) -> str:
        """Return the command that gives the same result, on one machine bit for bit."""
        words = ["rotorpong", "suite", self.what]
        for field in fields(self):
            value = getattr(self, field.name)
            said = field.name in ALWAYS or value != field.default
            if said and field.name not in LEFT_OUT:
                flag = f"--{field.name.replace('_', '-')}"
                words += [flag] if value is True else [flag, str(value)]
        return shlex.join(words)

    def _check(self) -> None:
        from rotorpong.conventions import InputError

        if self.seed != 0:
            raise InputError(f"--seed {self.seed}: the seeds of a suite are fixed; expected none")
        if self.resume and self.out is None:
            raise InputError("--resume: expected --out beside it")

    def _entrant(self) -> Any:
        from rotorpong.lab import train
        from rotorpong.lab.suite.playing import Entrant

        spec = self.spec()
        if self.experience is None:
            return Entrant(spec)
        known = knowledge_of(spec, self.experience)
        return Entrant(spec, known, train.knowledge_of(self.experience)[0])

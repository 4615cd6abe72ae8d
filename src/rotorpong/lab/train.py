"""Training: serve after serve, learning from each hit, every trial kept before the next begins.

A run can be killed at any time and resumed: its generators depend on (seed, trial) alone and the
learner is a function of the kept trials, so the end is the same as without the interruption.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rotorpong import __version__
from rotorpong.conventions import InputError
from rotorpong.experience import (
    Demonstration,
    Run,
    Store,
    Trial,
    create,
    open_store,
    shipped_demonstrations,
)
from rotorpong.experience.truth import TruthRow, record
from rotorpong.lab.control_settings import PAPERS_CONTROL
from rotorpong.lab.demonstrate import PILOT, Progress
from rotorpong.lab.evaluate import Knowledge, make_player, remember
from rotorpong.lab.learners import Learner
from rotorpong.lab.spec import LEARNERS, Spec
from rotorpong.lab.statistics import rate
from rotorpong.lab.trial import Played, Stage, play_trial, stage_of
from rotorpong.play.lessons import reward_of

MOST_BALLS_PER_HIT = 20


@dataclass(frozen=True, slots=True)
class Trained:
    """How a training run stands."""

    balls: int
    hits: int

    def as_json(self) -> dict[str, Any]:
        """Return how it stands as `train --json` prints it."""
        return {"balls": self.balls, "hits": self.hits, "hit_rate": rate(self.hits, self.balls)}


def train(
    spec: Spec,
    hits: int,
    path: Path,
    *,
    resume: bool = False,
    demonstrations: Sequence[Demonstration] | None = None,
    progress: Progress | None = None,
) -> Trained:
    """Train until `hits` own hits or 20 balls for each, keeping everything in `path`.

    Args:
        spec: what is played; its player must be one that learns.
        hits: how many own hits, beyond the demonstrations.
        path: the experience file.
        resume: go on with an existing file.
        demonstrations: to start from; the ten shipped ones by default.
        progress: called with (hits so far, hits).

    Raises:
        InputError: the player cannot learn.
        StoreError: the file exists and `resume` is off, or it holds another run.
    """
    if spec.player not in LEARNERS:
        raise InputError(
            f"player {spec.player!r} cannot learn: expected one of {', '.join(LEARNERS)}"
        )
    if path.is_dir():
        raise InputError(f"{path}: is a folder; expected a file for the experience")
    shown = tuple(shipped_demonstrations() if demonstrations is None else demonstrations)
    player = make_player(spec, Knowledge(shown), explore=True)
    stage = stage_of(spec, "train")
    with _opened(path, run_of(spec), shown, resume=resume) as store:  # when nothing else can fail
        return _train(stage, player, hits, store, progress)


def knowledge_of(path: Path) -> tuple[Run, Knowledge]:
    """Return which run a file holds, and what can be learnt from it."""
    with open_store(path, readonly=True) as store:
        return store.run, Knowledge(store.demonstrations(), store.trials())


def run_of(spec: Spec) -> Run:
    """Return the record by which a resumed run proves that it is the same run."""
    return Run(
        id=0,
        seed=spec.seed,
        player=spec.player,
        eyes=spec.eyes,
        vehicle=spec.vehicle_name,
        camera=spec.camera_name,
        serves=spec.serves_name,
        version=__version__,
        pilot=PILOT,
        spec={"racket": spec.racket, "blackout": spec.blackout} | _unusual(spec),
    )


def _unusual(spec: Spec) -> dict[str, Any]:
    """Return what older runs do not mention, where it is not as they had it."""
    found = {
        "randomize": spec.randomize,
        "ball": "" if spec.ball == "orange" else spec.ball,
        "eye_settings": spec.eye_settings.unusual(spec.eyes, spec.ball),
        "player_settings": spec.player_settings.unusual(spec.player),
        "control": "" if spec.control == PAPERS_CONTROL else spec.control,
        "contents": spec.contents(),
    }
    return {what: value for what, value in found.items() if value}


def _opened(
    path: Path, run: Run, demonstrations: tuple[Demonstration, ...], *, resume: bool
) -> Store:
    if not (resume and path.exists()):
        store = create(path, run)
        store.add_demonstrations(demonstrations)
        return store
    store = open_store(path)
    try:
        store.check_run(run)
        store.add_demonstrations(demonstrations)
    except BaseException:
        store.close()
        raise
    return store


def _train(
    stage: Stage, player: Learner, hits: int, store: Store, progress: Progress | None
) -> Trained:
    trials = store.trials()
    remember(player, trials)
    index, won = len(trials), sum(trial.outcome == "hit" for trial in trials)
    while won < hits and index < MOST_BALLS_PER_HIT * hits:
        played = play_trial(stage, index, player)
        store.add_trial(_trial(played, player), truth=record(_truth(played)))
        player.learn(played.verdict)
        index, won = index + 1, won + (played.outcome == "hit")
        if progress is not None:
            progress(won, hits)
    return Trained(index, won)


def _trial(played: Played, player: Learner) -> Trial:
    verdict = played.verdict
    return Trial(
        played.index,
        verdict.outcome,
        reward_of(verdict),
        player.attempt(verdict),
        verdict.contact_offset,
        verdict.contact_time,
    )


def _truth(played: Played) -> TruthRow:
    truth, ball = played.truth, played.serve.ball
    return TruthRow(
        played.index,
        played.miss_distance,
        played.time_error,
        truth.landing_x,
        ball.position,
        ball.velocity,
        ball.spin,
    )

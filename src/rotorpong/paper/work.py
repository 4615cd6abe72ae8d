"""Work in pieces whose answers are kept: what is done once is not done again.

    FOLDER/work-STATE/runs/DIGEST.sqlite      training runs, trial by trial
    FOLDER/work-STATE/ITEM/KEY-DIGEST.json    answers

STATE names the sources of this package: after a change of any of them all work begins anew. Every
file is there whole or not at all, and training resumes by itself, so a run that was killed at any
instant ends with what it would have ended with.
"""

import hashlib
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import rotorpong
from rotorpong.files import write_whole
from rotorpong.lab.train import run_of, train
from rotorpong.lab.workers import in_workers
from rotorpong.paper.findings import Answers, Job, Training

Progress = Callable[[str, int, int], None]
"""(what, done, of how many), called as work goes on."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A job or a training run, and where its answer is kept."""

    what: Job | Training
    answer: Path
    runs: tuple[Path, ...]  # experience files: of the training, or of the job's trainings


def answers_of(
    jobs: Mapping[str, Sequence[Job]],
    folder: Path,
    *,
    workers: int = 1,
    progress: Progress | None = None,
) -> dict[str, Answers]:
    """Return the answers of all jobs by item and key, working out what is not kept yet.

    Args:
        jobs: by item; keys are unique within one.
        folder: where work is kept.
        workers: processes.
        progress: told about training runs, then about jobs.

    Raises:
        InputError: the folder cannot be written.
    """
    tell = progress or (lambda *_: None)
    base = folder / f"work-{state()}"
    pieces = {(item, job.key): _piece(base, item, job) for item, js in jobs.items() for job in js}
    trainings = {
        run: Piece(training, run.with_suffix(".json"), (run,))
        for piece in pieces.values()
        if isinstance(piece.what, Job)
        for training, run in zip(piece.what.trainings, piece.runs, strict=True)
    }
    for place in {piece.answer.parent for piece in (*trainings.values(), *pieces.values())}:
        place.mkdir(parents=True, exist_ok=True)
    _do("training runs", list(trainings.values()), workers, tell)
    _do("pieces of work", list(pieces.values()), workers, tell)
    return {
        item: {job.key: json.loads(pieces[item, job.key].answer.read_text()) for job in js}
        for item, js in jobs.items()
    }


@cache
def state() -> str:
    """Return a name for the sources of this package."""
    package = Path(rotorpong.__file__).parent
    digest = hashlib.sha256(rotorpong.__version__.encode())
    for path in sorted(p for p in package.rglob("*") if p.suffix in (".py", ".json")):
        digest.update(f"\0{path.relative_to(package).as_posix()}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:12]


def _piece(base: Path, item: str, job: Job) -> Piece:
    runs = tuple(_run(base, training) for training in job.trainings)
    named = (job.function.__module__, job.function.__qualname__)
    words = (named, job.arguments, [run.name for run in runs])
    name = re.sub(r"[^a-z0-9]+", "-", job.key.lower()).strip("-")
    return Piece(job, base / item / f"{name}-{_digest(words)}.json", runs)


def _run(base: Path, training: Training) -> Path:
    identity = {**run_of(training.spec).identity(), "hits": training.hits}
    return base / "runs" / f"{_digest(sorted(identity.items()))}.sqlite"


def _digest(words: Any) -> str:
    return hashlib.sha256(repr(words).encode()).hexdigest()[:12]


def _do(what: str, pieces: Sequence[Piece], workers: int, tell: Progress) -> None:
    """Work out what has no answer yet, the longest first."""
    todo = [piece for piece in pieces if not piece.answer.exists()]
    todo.sort(key=_seconds, reverse=True)
    done = len(pieces) - len(todo)
    tell(what, done, len(pieces))
    for _ in _each(todo, min(workers, len(todo))):
        done += 1
        tell(what, done, len(pieces))


def _seconds(piece: Piece) -> float:
    return piece.what.seconds if isinstance(piece.what, Job) else float(piece.what.hits)


def _each(todo: Sequence[Piece], workers: int) -> Iterator[None]:
    if workers < 2:
        return map(_work, todo)
    return in_workers(_work, todo, workers=workers)


def _work(piece: Piece) -> None:
    if isinstance(piece.what, Training):
        answer = train(piece.what.spec, piece.what.hits, piece.runs[0], resume=True).as_json()
    else:
        answer = piece.what.function(*piece.what.arguments, *piece.runs)
    write_whole(piece.answer, json.dumps(answer, allow_nan=False).encode())

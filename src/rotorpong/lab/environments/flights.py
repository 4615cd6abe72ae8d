"""The serves of a vector of environments: in lockstep where all rows meet the same world.

With `randomize` every serve meets a vehicle and a camera of its own, so each row flies by itself;
the rows are the same either way.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from jaxtyping import Bool, Float
from numpy import ndarray

from rotorpong.drone import Outcome
from rotorpong.lab.environments.arena import Arena, Place
from rotorpong.world.batch import ServeBatch


class Flights:
    """n serves, each on its way or over."""

    def __init__(self, arena: Arena, places: Sequence[Place]) -> None:
        """Let every row hover at home at the instant of its release."""
        self._arena = arena
        met = [arena.meet(place) for place in places]
        if arena.spec.randomize:
            self._batches = [ServeBatch(setting, [cast]) for setting, cast in met]
        else:
            self._batches = [ServeBatch(arena.setting, [cast for _, cast in met])]

    @property
    def over(self) -> Bool[ndarray, "n"]:
        """Which serves are over."""
        return np.concatenate([batch.over for batch in self._batches])

    @property
    def outcomes(self) -> list[Outcome | None]:
        """What became of each serve; None where it is not over."""
        return [outcome for batch in self._batches for outcome in batch.outcomes]

    @property
    def miss_distances(self) -> Float[ndarray, "n"]:
        """How near the blade came to each ball, m; nan where it is not over."""
        return np.concatenate([batch.miss_distances for batch in self._batches])

    @property
    def time_errors(self) -> Float[ndarray, "n"]:
        """How late the blades were, s; nan where that cannot be told or the serve is not over."""
        return np.concatenate([batch.time_errors for batch in self._batches])

    def states(self) -> Float[ndarray, "n 18"]:
        """Return what `world.batch.STATE` names of every row."""
        return np.concatenate([batch.states() for batch in self._batches])

    def restart(self, row: int, place: Place) -> None:
        """Begin a new serve in a row."""
        setting, cast = self._arena.meet(place)
        if self._arena.spec.randomize:
            self._batches[row] = ServeBatch(setting, [cast])
        else:
            self._batches[0].restart([row], [cast])

    def command(self, velocities: Float[ndarray, "n 4"], told: Bool[ndarray, "n"]) -> None:
        """Fly at these velocities, m/s and rad/s, in the rows that are told."""
        for batch, rows in self._parts():
            batch.command(velocities[rows], told[rows])

    def advance(self) -> None:
        """Let every row that is not over run until its next frame arrives, or its serve is over."""
        for batch in self._batches:
            batch.advance()

    def _parts(self) -> Iterator[tuple[ServeBatch, slice]]:
        """Yield every batch with its rows."""
        first = 0
        for batch in self._batches:
            last = first + len(batch.over)
            yield batch, slice(first, last)
            first = last

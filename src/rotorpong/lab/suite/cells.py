"""What a suite is made of: cells, each so many balls of one setting of the game.

A suite is frozen. Whoever wants other balls, vehicles, cameras or counts makes another suite, and
leaves the old one to those who compare with what it gave.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

from rotorpong.lab.spec import Spec
from rotorpong.physics.camera import CAMERAS, Camera


@dataclass(frozen=True, slots=True)
class Cell:
    """Balls of one setting."""

    name: str
    vehicle: str
    camera: str
    serves: str
    balls: int
    seed: int
    camera_pitch_deg: float = 0.0  # upwards
    randomize: bool = False

    def camera_profile(self) -> Camera:
        """Return the camera, pitched."""
        return replace(CAMERAS[self.camera], camera_pitch_deg=self.camera_pitch_deg)

    def spec(self, player: Spec) -> Spec:
        """Return the spec of a player in this cell.

        Args:
            player: whose player and eyes, with their settings, are taken.
        """
        camera = self.camera_profile() if self.camera_pitch_deg else self.camera
        return replace(
            player,
            vehicle=self.vehicle,
            camera=camera,
            serves=self.serves,
            randomize=self.randomize,
            seed=self.seed,
        )


@dataclass(frozen=True, slots=True)
class Suite:
    """A frozen benchmark."""

    name: str
    cells: tuple[Cell, ...]


_cell = partial(Cell, balls=300, seed=2015)  # nothing was chosen on this seed

V1 = Suite(
    "v1",
    (
        _cell("human", "tum_gazebo", "gazebo", "human"),
        _cell("human_720p", "tum_gazebo", "ardrone2_720p", "human"),
        _cell("hard", "tum_gazebo", "gazebo", "hard"),
        _cell("randomized", "ardrone2", "ardrone2_720p", "human", randomize=True),
        _cell("lob", "tum_gazebo", "gazebo", "lob"),
        _cell("lob_pitched", "tum_gazebo", "gazebo", "lob", camera_pitch_deg=15.0),
        _cell("constant", "tum_gazebo", "gazebo", "constant"),
    ),
)
SUITES: Mapping[str, Suite] = {suite.name: suite for suite in (V1,)}
QUICK_BALLS = 20  # of each cell: the first

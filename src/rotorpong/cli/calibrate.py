"""Commands that learn from the user's pictures what `--camera` and `--colour` take: calibrate."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from tyro.conf import Positional, subcommand

from rotorpong.cli.common import Common, named, progress_bar, show


@dataclass(frozen=True, kw_only=True)
class CalibrateCamera(Common):
    """Calibrate a camera from pictures of a chessboard."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    folder: Positional[Path]
    """Pictures of one flat board, tilted differently, all over the picture; ten or more."""
    out: Path
    """FILE.json, or FILE.yaml in ROS's layout, for `--camera`."""
    board: str = "9x6"
    """Inner corners, columns x rows: 9x6 for a board of 10 x 7 squares."""
    square_mm: float = 25.0
    """Side of a square. It does not change the lens."""
    frames_per_second: float = 30.0
    """Of the camera, for the file: the pictures do not tell it."""

    def run(self) -> dict[str, Any]:
        """Calibrate."""
        from rotorpong.lab.calibrate_camera import board_from, calibrate_camera
        from rotorpong.lab.tables import camera_table

        board = board_from(self.board, self.square_mm)
        with progress_bar() as advance:
            result = calibrate_camera(
                self.folder,
                self.out,
                board,
                named(advance, "pictures"),
                frames_per_second=self.frames_per_second,
            )
        if not self.json:
            show(camera_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class CalibrateColour(Common):
    """Learn a ball's colour from boxes around balls."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    boxes: Positional[Path]
    """CSV of picture,x0,y0,x1,y1: pixels, ends exclusive, paths from the CSV's folder."""
    out: Path
    """FILE.json for `detect --colour`."""
    name: str | None = None
    """What `detect` calls it. Default: FILE."""

    def run(self) -> dict[str, Any]:
        """Learn."""
        from rotorpong.lab.calibrate_colour import calibrate_colour
        from rotorpong.lab.tables import colour_table

        with progress_bar() as advance:
            progress = named(advance, "pictures, twice")
            result = calibrate_colour(self.boxes, self.out, self.name, progress)
        if not self.json:
            show(colour_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class Calibrate:
    """Calibrate your camera, or your ball's colour, from pictures."""

    command: Annotated[
        Annotated[CalibrateCamera, subcommand("camera")]
        | Annotated[CalibrateColour, subcommand("colour")],
        tyro.conf.arg(name=""),
    ]

    @property
    def json(self) -> bool:
        """Whether JSON is asked for."""
        return self.command.json

    @property
    def seed(self) -> int:
        """The seed of what was chosen."""
        return self.command.seed

    def run(self) -> dict[str, Any]:
        """Run what was chosen."""
        return self.command.run()

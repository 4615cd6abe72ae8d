"""Commands that look at what comes from outside or from the court: detect, serves, doctor."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from tyro.conf import FlagCreatePairsOff, Positional, subcommand

from rotorpong.cli.common import Common, compile_kernels, named, progress_bar, show


@dataclass(frozen=True, kw_only=True)
class Detect(Common):
    """Find balls in pictures, folders of pictures, and videos."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    path: Positional[tuple[Path, ...]]
    """Pictures, folders, videos."""
    camera: str | None = None
    """gazebo, ardrone2_360p, ardrone2_720p or a calibration FILE: adds positions in metres."""
    eyes: str = "paper"
    """paper, or tracker: measured to hundredths of a pixel, and linked over the frames of a video
    or of pictures numbered one after the other."""
    colour: str = "orange"
    """orange, white, a FILE.json of `calibrate colour`, or several: orange,FILE.json."""
    ball_diameter_mm: float = 40.0
    """Of the real ball."""
    min_score: float = 0.0
    """Leave out what looks less like a ball than this, 0 to 1."""
    circle_fit: str | None = None
    """Of eyes paper: kasa (regularised least squares, the default), pratt, taubin or geometric. The
    others and whole pixels take outlines and scores of the quick search, as the paper's eyes."""
    diameter: str | None = None
    """Of eyes paper: whole pixels as in the paper, or float (the default)."""
    out: Path | None = None
    """Folder for annotated pictures and, of videos, films; or FILE.mp4 for that of one video."""

    def run(self) -> dict[str, Any]:
        """Detect."""
        from rotorpong.lab.detect import Search, detect_all
        from rotorpong.lab.tables import detection_table

        search = Search(
            self.camera,
            self.eyes,
            tuple(self.colour.split(",")),
            self.ball_diameter_mm / 1000.0,
            self.min_score,
            self.circle_fit,
            self.diameter,
        )
        with progress_bar() as advance:
            result = detect_all(self.path, search, self.out, named(advance, "pictures"))
        if not self.json:
            show(detection_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class FromFlight(Common):
    """Turn a measured flight, or a folder of them, into serves."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    flight: Positional[Path]
    """CSV of time and position, or a folder."""
    out: Path
    """The CSV of serves that `evaluate --serves` throws."""

    def run(self) -> dict[str, Any]:
        """Convert."""
        from rotorpong.files import target_of
        from rotorpong.lab.from_flight import convert
        from rotorpong.lab.serve_files import write_serves
        from rotorpong.lab.tables import conversion_table

        target_of(self.out)  # nothing is fitted for a place that cannot be written
        conversion = convert(self.flight)
        write_serves(self.out, tuple(made.serve for made in conversion.serves))
        result = {**conversion.as_json(), "out": str(self.out)}
        if not self.json:
            show(conversion_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class Stats(Common):
    """Describe a kind of serves as a camera sees them."""

    serves: str = "human"
    """human, constant, hard, lob, or FILE.csv."""
    camera: str = "gazebo"
    """gazebo, ardrone2_360p, ardrone2_720p, or your calibration as FILE."""
    balls: int = 200
    """How many serves."""

    def run(self) -> dict[str, Any]:
        """Throw them at a hovering drone."""
        from rotorpong.lab.serve_stats import serve_stats
        from rotorpong.lab.spec import Spec, require_count
        from rotorpong.lab.tables import stats_table

        require_count("balls", self.balls)
        spec = Spec("hover", camera=self.camera, serves=self.serves, seed=self.seed).check()
        compile_kernels()
        with progress_bar() as advance:
            result = serve_stats(spec, self.balls, progress=named(advance, "balls"))
        if not self.json:
            show(stats_table(result))
        return result


@dataclass(frozen=True, kw_only=True)
class Serves:
    """Serves: where they come from and what they are like."""

    command: Annotated[
        Annotated[FromFlight, subcommand("from-flight")] | Annotated[Stats, subcommand("stats")],
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


@dataclass(frozen=True, kw_only=True)
class Doctor(Common):
    """Say what this machine has, and whether rotorpong works on it."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    clear_cache: FlagCreatePairsOff[bool] = False
    """Delete the compiled kernels first."""

    def run(self) -> dict[str, Any]:
        """Examine."""
        from rotorpong.lab.doctor import examine
        from rotorpong.lab.tables import findings_table

        with progress_bar() as advance:
            result = examine(clear_cache=self.clear_cache, progress=named(advance, "checks"))
        if not self.json:
            show(findings_table(result))
        return result

"""The command that tries the flight filter on measured flights: predict."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tyro.conf import Positional

from rotorpong.cli.common import Common, compile_kernels, named, progress_bar, show


@dataclass(frozen=True, kw_only=True)
class Predict(Common):
    """Predict measured flights with the tracker's flight filter, and say how far off it is."""

    seed: int = 0
    """Taken by every command; nothing is drawn here."""
    flight: Positional[Path]
    """CSV of time and position, or a folder of them: origin at the table's centre, z up, one frame
    to a folder."""
    window_s: float = 0.15
    """Length of the points that the filter sees."""
    ahead_s: float = 0.2
    """How long after the last of them its prediction is compared."""
    point_sd_mm: float = 1.5
    """Standard deviation of a measured coordinate."""
    stamp_sd_ms: float = 0.3
    """Standard deviation of a time stamp."""
    table_height_m: float | None = None
    """Of the playing surface in the files. Default: by the bounces of the folder's other flights, 0
    with fewer than 5 of them."""

    def run(self) -> dict[str, Any]:
        """Predict."""
        from rotorpong.lab.predict import Question, predict_flights
        from rotorpong.lab.tables import prediction_table
        from rotorpong.vision.flight_points import PointNoise

        noise = PointNoise(1e-3 * self.point_sd_mm, 1e-3 * self.stamp_sd_ms)
        question = Question(self.window_s, self.ahead_s, noise, self.table_height_m).check()
        compile_kernels()
        with progress_bar() as advance:
            result = predict_flights(self.flight, question, named(advance, "flights"))
        if not self.json:
            show(prediction_table(result))
        return result

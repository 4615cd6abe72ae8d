"""The order in which the gallery shows the examples: from the player down to the camera."""

ORDER = (
    "own_player.py",
    "train_intercept.py",
    "own_vehicle.py",
    "point_mass.py",
    "write_flight.py",
    "draw_calibration.py",
)


class place:  # noqa: N801 - sphinx-gallery makes one for a folder and calls it
    """Tell where an example stands."""

    def __init__(self, folder: str) -> None:
        """Stand ready for the examples of `folder`."""

    def __call__(self, name: str) -> int:
        """Return the place of an example, by its file's name."""
        return ORDER.index(name)

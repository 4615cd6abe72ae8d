"""What is played against what: everything that decides the result of a command.

A spec is frozen and cheap to pickle, so a worker process builds from it the same world, eyes and
player as the parent. Vehicle, camera and kind of serve are named, or passed as objects of one's
own. Everything is checked here, at the door.
"""

import hashlib
import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

from rotorpong.conventions import InputError, require_seed
from rotorpong.drone import Eyes, Player
from rotorpong.files import digest_of
from rotorpong.lab.choices import require_choice
from rotorpong.lab.control_settings import require_control
from rotorpong.lab.eye_settings import EYES, NOTHING_SET, EyeSettings
from rotorpong.lab.player_settings import DECIDING_ONCE, USUAL, PlayerSettings
from rotorpong.lab.randomize import require_randomizable
from rotorpong.lab.serving import SERVE_KINDS, serve_source
from rotorpong.lab.tracking import tracker_eyes
from rotorpong.physics.ardrone2 import ARDRONE2, ARDRONE2_RAW
from rotorpong.physics.camera import CAMERAS, Camera
from rotorpong.physics.vehicle import TUM_GAZEBO, Vehicle
from rotorpong.vision import PaperEyes, read_camera
from rotorpong.vision.colour import Colour
from rotorpong.world.looks import BALL_COLOURS, BallColour, plain_looks
from rotorpong.world.racket import RACKETS
from rotorpong.world.serves import KINDS, ServeKind
from rotorpong.world.simulated_drone import Setting, SimulatedDrone
from rotorpong.world.truth_eyes import TruthEyes

PLAYERS = ("hover", *DECIDING_ONCE, "oracle")
LEARNERS = ("single", "paper", "bandit")
VEHICLES: dict[str, Vehicle] = {v.name: v for v in (TUM_GAZEBO, ARDRONE2, ARDRONE2_RAW)}
LARGEST_COUNT = 10_000_000


@dataclass(frozen=True, slots=True)
class Spec:
    """One setting of the game. Texts are names, or files where files are possible."""

    player: str = "paper"
    eyes: str = "paper"
    vehicle: str | Vehicle = "tum_gazebo"
    camera: str | Camera = "gazebo"
    serves: str | ServeKind = "human"
    seed: int = 0
    racket: str = "cardboard"
    blackout: bool = False
    randomize: bool = False  # every trial meets a drone, ball, camera and room of its own
    ball: str = "orange"  # its colour
    eye_settings: EyeSettings = NOTHING_SET
    player_settings: PlayerSettings = USUAL
    control: str | None = None  # how motions are flown; None: open, as the paper does

    def check(self) -> "Spec":
        """Return the spec if everything in it can be built.

        Raises:
            InputError: something is unknown, unreadable or does not go together.
        """
        if self.is_own_player:
            own_player(self.player)
        else:
            require_choice("player", self.player, PLAYERS, "or your own as FILE.py:CLASS")
        self.player_settings.check(self.player)
        require_choice("eyes", self.eyes, EYES)
        require_choice("ball", self.ball, BALL_COLOURS)
        self.eye_settings.check(self.eyes, self.ball)
        require_control(self.control, self.player)
        self._check_oracle()
        if isinstance(self.vehicle, str):
            require_choice("vehicle", self.vehicle, tuple(VEHICLES))
        require_choice("racket", self.racket, tuple(RACKETS))
        require_seed(self.seed)
        if self.blackout and self.eyes == "truth":
            raise InputError("--blackout with eyes truth: they look at no frame; choose paper eyes")
        if self.randomize:
            require_randomizable(self.setting().vehicle)
        self.camera_profile()
        if not isinstance(self.serves, str) or self.serves not in SERVE_KINDS:
            serve_source(self.serves, self.seed)
        return self

    def _check_oracle(self) -> None:
        if self.player == "oracle" and self.blackout:
            raise InputError("--blackout with player oracle: it looks at no frame; choose another")
        if self.player == "oracle" and self.eyes != "truth":
            raise InputError(f"player oracle with eyes {self.eyes!r}: expected eyes truth")

    @property
    def is_own_player(self) -> bool:
        """Whether the player is a user's own class."""
        return ".py:" in self.player

    @property
    def vehicle_name(self) -> str:
        """How the vehicle is called in results."""
        return self.vehicle if isinstance(self.vehicle, str) else self.vehicle.name

    @property
    def camera_name(self) -> str:
        """How the camera is called in results."""
        return self.camera if isinstance(self.camera, str) else self.camera.name

    @property
    def serves_name(self) -> str:
        """How the serves are called in results."""
        return self.serves if isinstance(self.serves, str) else self.serves.name

    def camera_profile(self) -> Camera:
        """Return the camera: a profile by name, the user's calibration file, or as passed."""
        return camera_named(self.camera) if isinstance(self.camera, str) else self.camera

    @property
    def ball_colour(self) -> BallColour:
        """The colour of the ball that is thrown."""
        return cast("BallColour", self.ball)

    def colour(self) -> Colour:
        """Return the colour that eyes look for.

        Raises:
            InputError: its file cannot be read.
        """
        return self.eye_settings.colour_of(self.ball)

    def setting(self) -> Setting:
        """Return what the serves meet."""
        vehicle = VEHICLES[self.vehicle] if isinstance(self.vehicle, str) else self.vehicle
        return Setting(
            vehicle,
            self.camera_profile(),
            racket=RACKETS[self.racket],
            scene=plain_looks(self.ball_colour),
            blackout=self.blackout,
        )

    def contents(self) -> dict[str, str]:
        """Return a digest of each part that is no name: what its file holds, whatever its name."""
        found = {}
        camera = self.camera_profile()
        if CAMERAS.get(camera.name) != camera:
            found["camera"] = _digest_of_record(camera)
        if isinstance(self.serves, ServeKind):
            if KINDS.get(self.serves.name) != self.serves:
                found["serves"] = _digest_of_record(self.serves)
        elif self.serves not in SERVE_KINDS:
            found["serves"] = digest_of(Path(self.serves))
        colour = self.eye_settings.digest(self.ball) if self.eyes != "truth" else None
        return found if colour is None else {**found, "colour": colour}

    def make_eyes(self, drone: SimulatedDrone, camera: Camera | None = None) -> Eyes:
        """Return fresh eyes for one serve.

        Args:
            drone: whose frames they get.
            camera: what they take its camera for; None: they know it exactly.
        """
        if self.eyes == "truth":
            return TruthEyes(drone)
        lens = camera or drone.camera
        if self.eyes == "tracker":
            return tracker_eyes(lens, self.vehicle_name, self.serves_name, self.colour())
        return PaperEyes(
            lens,
            whole_pixels=self.eye_settings.whole_pixels,
            fit=self.eye_settings.fit,
            colour=self.colour(),
        )


def _digest_of_record(record: Camera | ServeKind) -> str:
    """Return a digest of what an object of one's own says, whatever its name."""
    return hashlib.sha256(repr(replace(record, name="")).encode()).hexdigest()


def camera_named(name: str) -> Camera:
    """Return a camera profile by name, or from the user's calibration file.

    Raises:
        InputError: neither a profile nor a readable calibration.
    """
    if name in CAMERAS:
        return CAMERAS[name]
    if not (name and Path(name).exists()):
        raise InputError(
            f"camera {name!r}: expected one of {', '.join(CAMERAS)}, "
            "or a calibration file (OpenCV YAML or JSON)"
        )
    return read_camera(name)


def require_count(what: str, given: int, least: int = 1) -> None:
    """Raise InputError unless `given` is a whole number from `least` to ten million."""
    if not least <= given <= LARGEST_COUNT:
        raise InputError(f"{what} {given}: expected a whole number from {least} to {LARGEST_COUNT}")


def own_player(name: str) -> Callable[[], Player]:
    """Load a user's class from `FILE.py:CLASS`.

    Raises:
        InputError: no such file or class, the file fails, or the class is no Player; what is
            returned raises it as well, if the class cannot be made again.
    """
    maker = _loaded(name)

    def make() -> Player:
        try:
            made = maker()
        except (Exception, SystemExit) as error:  # a user's class may fail in any way
            raise InputError(f"player {name!r}: {type(error).__name__}: {error}") from error
        if not isinstance(made, Player):
            raise InputError(
                f"player {name!r}: expected a class with play(drone, eyes, rng) and learn"
            )
        return made

    make()
    return make


def _loaded(name: str) -> Any:
    """Return the class of `FILE.py:CLASS`, or whatever has that name there."""
    path, _, class_name = name.rpartition(":")
    if not Path(path).is_file():
        raise InputError(f"player {name!r}: no file {path!r}; expected FILE.py:CLASS")
    module_spec = importlib.util.spec_from_file_location(f"player_{Path(path).stem}", path)
    if module_spec is None or module_spec.loader is None:
        raise InputError(f"player {name!r}: {path!r} is no Python file")
    module = importlib.util.module_from_spec(module_spec)
    sys.modules[module_spec.name] = module  # where dataclasses and pickle look for it
    try:
        module_spec.loader.exec_module(module)
        return getattr(module, class_name)
    except (Exception, SystemExit) as error:  # a user's file may fail in any way
        raise InputError(f"player {name!r}: {type(error).__name__}: {error}") from error

"""Compiling every kernel once, before anything is timed or worker processes start."""

from collections.abc import Callable

import numpy as np

from rotorpong.drone import HOVER
from rotorpong.lab.reachable import is_reachable
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.spec import Spec
from rotorpong.lab.trial import new_drone, stage_of
from rotorpong.physics.ardrone2 import ARDRONE2
from rotorpong.physics.ball import TABLE_SURFACE, Air, Ball, bounce, fly
from rotorpong.physics.vehicle import Vehicle
from rotorpong.primitives import Dmp, State
from rotorpong.world.batch import Cast, ServeBatch
from rotorpong.world.contact import Solids, state_of, touch_down
from rotorpong.world.sensors import draw_sensors, read
from rotorpong.world.serves import Serve, crossing
from rotorpong.world.simulated_drone import Setting

Step = Callable[[int, int], None]
STEPS = 4


def warm_up(progress: Step | None = None, *, eyes: str = "paper") -> None:
    """Run through every kernel; numba compiles what its cache does not hold (a minute or two).

    Args:
        progress: called with (steps done, steps).
        eyes: those of the tracker have many kernels of their own, which only they need.
    """
    tell = progress or (lambda done, steps: None)
    tell(0, STEPS)
    generators = trial_generators(0, "evaluate", 0)
    stage = stage_of(Spec())
    serve = stage.serves(0, generators.serve)
    crossing(serve)
    touch_down(state_of(serve.ball), Solids())
    tell(1, STEPS)
    fly_once(ARDRONE2, generators.vehicle)
    drone = new_drone(stage, 0)
    observation = drone.observe()
    drone.command(HOVER)
    drone.truth()
    play_once(serve, stage.setting)
    tell(2, STEPS)
    is_reachable(new_drone(stage, 0))
    if observation is not None:
        stage.spec.make_eyes(drone).see(observation)
    _take_frame(Spec(camera="ardrone2_360p"))
    tell(3, STEPS)
    ball = bounce(Ball(np.zeros(3), np.array([1.0, 0.0, -1.0]), np.zeros(3)), UP, TABLE_SURFACE)
    fly(ball, Air(), 0.1)
    rest = State(np.zeros(3), np.zeros(3))
    Dmp(np.zeros((20, 3))).roll_out(rest, rest, 1.0, np.linspace(0.0, 1.0, 3))
    if eyes == "tracker":
        _follow_once(Spec(eyes="tracker"))
    tell(STEPS, STEPS)


def fly_once(vehicle: Vehicle, rng: np.random.Generator) -> None:
    """Fly a vehicle and read its sensors, so that what they need is compiled."""
    state = vehicle.start(np.zeros(3), rng)
    _, track = vehicle.advance(state, np.zeros(4), ticks=10, new_command=True)
    read(draw_sensors(vehicle.sensor_noise, rng), track, 0)


def play_once(serve: Serve, setting: Setting) -> None:
    """Play a batch of one serve to its end."""
    generators = trial_generators(0, "evaluate", 0)
    batch = ServeBatch(setting, [Cast(serve, generators.vehicle, generators.sensors)])
    while not batch.over.all():
        batch.advance()
    batch.states()


def _follow_once(spec: Spec) -> None:
    """Follow a ball until the eyes have done all that they do."""
    drone = new_drone(stage_of(spec), 0)
    eyes = spec.make_eyes(drone)
    while (seen := drone.observe()) is not None:
        eyes.see(seen)
        drone.command(HOVER)


def _take_frame(spec: Spec) -> None:
    """Look at a few pixels of a frame of a full sensor."""
    observation = new_drone(stage_of(spec), 0).observe()
    if observation is not None:
        observation.frame.region(0, 0, 2, 2)


UP = np.array([0.0, 0.0, 1.0])

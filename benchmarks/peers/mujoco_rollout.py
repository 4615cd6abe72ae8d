"""MuJoCo: the same ball, alone and with a drone that is held to a velocity, by mujoco.rollout.

State only, one thread. The ball is a free sphere in an ellipsoid fluid whose coefficients give the
drag of rotorpong's ball; the drone a free body with velocity actuators on a planar cascade of
slides, so that it holds a commanded velocity as a velocity loop would. MuJoCo has neither delays
nor noise nor a 30 Hz command clock here, and its contact law has no restitution: it does less work
than what it is compared with. As many serves fly at once as a rollout has states, here and there.
"""

import functools
from typing import Any

import numpy as np

from rotorpong.conventions import BALL_RADIUS
from rotorpong.lab.bench.ball_rows import FLIGHT, some_balls
from rotorpong.lab.bench.rows import Row
from rotorpong.lab.bench.timing import REPETITIONS, WARM_UPS, cpu_seconds
from rotorpong.lab.seeds import trial_generators
from rotorpong.lab.serving import serve_source
from rotorpong.lab.spec import Spec
from rotorpong.physics.ball import Air, fly
from rotorpong.world.batch import STATE, Cast, ServeBatch
from rotorpong.world.solids import TICK

NAME = "mujoco-core, rollout"
BLUNT = 0.268  # fluid coefficient that gives a drag of 0.15 /m
BATCH = 32  # states in one call

BALL = f"""
<body name="ball" pos="2.3 0 0.3"><freejoint/>
  <geom type="sphere" size="{BALL_RADIUS}" mass="0.0027" fluidshape="ellipsoid"
        fluidcoef="{BLUNT} 0 0 0 0.35" solref="-1000000 -74"/>
</body>"""
DRONE = """
<body name="drone" pos="-1.9 0 0.19">
  <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
  <joint name="z" type="slide" axis="0 0 1"/><joint name="yaw" type="hinge" axis="0 0 1"/>
  <geom type="cylinder" size="0.26 0.05" mass="0.45"/>
  <geom type="ellipsoid" pos="0.23 0 0.16" size="0.004 0.075 0.0785" mass="0.01"/>
</body>"""
COURT = """
<geom type="plane" size="8 8 0.1" pos="0 0 -0.76"/>
<geom type="box" size="1.37 0.7625 0.0125" pos="0 0 -0.0125" solref="-1000000 -74"/>
<geom type="box" size="0.001 0.915 0.07625" pos="0 0 0.07625"/>"""
MOTORS = "".join(f'<velocity joint="{j}" kv="3"/>' for j in ("x", "y", "z", "yaw"))


def require() -> None:
    """Raise ImportError while MuJoCo is not installed."""
    import mujoco.rollout  # noqa: F401


def rows(*, quick: bool = False) -> tuple[Row, ...]:
    """Measure MuJoCo and rotorpong in turns and return the rows."""
    ours, theirs = _our_flights(quick=quick), _mujoco(BALL, FLIGHT, "RK4", quick=quick)
    flights = Row(
        "ball flights of 0.7 s against a peer", ours, "flights/s", None, "more", NAME, ours / theirs
    )
    ours, seconds = _our_serves(quick=quick)
    theirs = _mujoco(COURT + DRONE + BALL, seconds, "Euler", quick=quick)
    steps = theirs * seconds / TICK
    return (
        flights,
        Row(
            f"state-only serves, {BATCH} at once",
            ours,
            "serves/s",
            None,
            "more",
            NAME,
            ours / theirs,
        ),
        Row("the peer's steps of ball, drone and court, Euler 1 ms", steps, "steps/s"),
    )


def _our_flights(*, quick: bool) -> float:
    balls = some_balls(1000)
    return 1000 / cpu_seconds(lambda: fly(balls, Air(), FLIGHT), quick=quick)


def _our_serves(*, quick: bool) -> tuple[float, float]:
    """Return serves at a hovering drone per second, and how long such a serve lasts, s."""
    spec = Spec("hover")
    source, setting = serve_source(spec.serves, spec.seed), spec.setting()
    hover = np.zeros((BATCH, 4))

    def casts() -> list[Cast]:
        trials = [trial_generators(spec.seed, "evaluate", index) for index in range(BATCH)]
        return [
            Cast(source(index, drawn.serve), drawn.vehicle, drawn.sensors)
            for index, drawn in enumerate(trials)
        ]

    def work() -> None:
        batch.restart(range(BATCH), fresh.pop())
        while not batch.over.all():
            batch.advance()
            batch.command(hover)

    batch = ServeBatch(setting, casts())
    fresh = [casts() for _ in range(WARM_UPS + REPETITIONS)]
    seconds = cpu_seconds(work, quick=quick)
    durations = batch.states()[:, STATE.index("time_s")]
    return BATCH / seconds, float(np.mean(durations))


def _mujoco(bodies: str, duration: float, integrator: str, *, quick: bool) -> float:
    """Return rollouts of `duration` per second of CPU time."""
    import mujoco
    from mujoco import rollout

    model = _model(mujoco, bodies, integrator)
    data = mujoco.MjData(model)
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state = np.empty(size)
    data.qvel[-6:-3] = (-7.0, 0.0, 1.5)
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states = np.tile(state, (BATCH, 1))
    steps = round(duration / TICK)
    with rollout.Rollout(nthread=0) as runner:
        work = functools.partial(runner.rollout, model, [data], states, nstep=steps)
        return BATCH / cpu_seconds(work, quick=quick)


def _model(mujoco: Any, bodies: str, integrator: str) -> Any:
    motors = MOTORS if "drone" in bodies else ""
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <option integrator="{integrator}" timestep="{TICK}" density="1.2"/>
      <worldbody>{bodies}</worldbody><actuator>{motors}</actuator>
    </mujoco>""")

"""A batch of serves is its serves, bit for bit."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import VelocityCommand
from rotorpong.physics.ball import RUBBER, TABLE_SURFACE, Air
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO
from rotorpong.physics.vehicle import NOISE_FREE_CASCADE, TUM_GAZEBO, TumGazebo
from rotorpong.world.batch import STATE, Cast, ServeBatch
from rotorpong.world.racket import HOME_BODY, Racket
from rotorpong.world.serves import HUMAN, draw, draw_at
from rotorpong.world.simulated_drone import Setting, SimulatedDrone

REAL = Setting(TUM_GAZEBO, GAZEBO)
DELAYED = Setting(TUM_GAZEBO, ARDRONE2_720P, racket=Racket(RUBBER))
N = 24


def rng(seed):
    return np.random.default_rng(seed)


def serves():
    """Serves of all ends, one of them in another air over another table."""
    drawn = [draw(HUMAN, rng(seed)) for seed in range(N - 4)]
    aimed = [draw_at(HUMAN, (0.02 * i, 0.02 * i), rng(i)) for i in range(4)]
    other = replace(drawn[0], air=Air(0.12, 0.001), table=TABLE_SURFACE._replace(friction=0.4))
    return [other, *drawn[1:], *aimed]


SERVES = serves()


def generators(seed):
    return {"vehicle_rng": rng(seed), "sensor_rng": rng(seed + 1000)}


def casts(seeds=range(N)):
    return [Cast(SERVES[seed], **generators(seed)) for seed in seeds]


def orders(seed, n=100):
    """What row `seed` is told, frame by frame; not all within the limits."""
    generator = rng(seed + 2000)
    steady = generator.uniform([-1.5, -3, -1, -2], [1.5, 3, 1, 2])
    return steady + generator.normal(0.0, 0.2, size=(n, 4))


def alone(seed, setting, *, told):
    drone = SimulatedDrone(SERVES[seed], setting, **generators(seed))
    seen, sent = [], []
    for order in orders(seed):
        observation = drone.observe()
        if observation is None:
            break
        seen.append(
            tuple(round(1000 * t) for t in (observation.frame_time, observation.arrival_time))
        )
        if told(len(seen)):
            sent.append(drone.command(VelocityCommand(*order.tolist())))
    return drone, seen, sent


def together(setting, *, told=lambda frame: True, seeds=range(N)):
    batch, frame = ServeBatch(setting, casts(seeds)), 0
    times = []
    told_all = np.stack([orders(seed) for seed in seeds])
    while not batch.over.all():
        batch.advance()
        frame += 1
        now, age = batch.states()[:, 16:].T
        times.append((np.rint(1000 * (now - age)), np.rint(1000 * now), batch.over))
        if told(frame):
            batch.command(told_all[:, frame - 1])
    return batch, times


def assert_same_truth(one, other):
    for name in ("verdict", "miss_distance", "time_error", "landing_x"):
        assert getattr(one, name) == getattr(other, name), name
    for name in ("ball_path", "body_path", "blade_path"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert len(one.contacts) == len(other.contacts)
    for touch, again in zip(one.contacts, other.contacts, strict=True):
        assert (touch.time, touch.solid, touch.facing) == (again.time, again.solid, again.facing)


@pytest.mark.parametrize("setting", [REAL, DELAYED], ids=["gazebo", "ardrone2_720p"])
def test_each_row_is_what_a_simulated_drone_does_alone(setting):
    batch, _ = together(setting)
    outcomes = set()
    for seed in range(N):
        truth = alone(seed, setting, told=lambda frame: True)[0].truth()
        assert_same_truth(batch.truth(seed), truth)
        assert batch.outcomes[seed] == truth.verdict.outcome
        assert batch.miss_distances[seed] == truth.miss_distance
        late = batch.time_errors[seed]
        assert (None if np.isnan(late) else late) == truth.time_error
        outcomes.add(truth.verdict.outcome)
    assert len(outcomes) >= 3


def test_a_command_that_is_not_renewed_stays_in_force_without_a_new_message():
    batch, _ = together(REAL, told=lambda frame: frame % 3 == 1)
    for seed in range(N):
        drone, _, _ = alone(seed, REAL, told=lambda frame: frame % 3 == 1)
        assert_same_truth(batch.truth(seed), drone.truth())


def test_a_batch_that_is_told_nothing_hovers():
    batch, _ = together(REAL, told=lambda frame: False)
    outcomes = set()
    for seed in range(N):
        truth = alone(seed, REAL, told=lambda frame: False)[0].truth()
        assert_same_truth(batch.truth(seed), truth)
        outcomes.add(truth.verdict.outcome)
    assert "hit" in outcomes


def test_frames_come_when_each_drone_alone_would_get_them():
    _, times = together(DELAYED)
    for seed in range(N):
        seen = alone(seed, DELAYED, told=lambda frame: True)[1]
        mine = [(e[seed], a[seed]) for e, a, over in times if not over[seed]]
        assert mine == seen


def test_rows_do_not_know_of_each_other():
    whole, _ = together(REAL)
    part, _ = together(REAL, seeds=[7, 3, 11])
    for row, seed in enumerate([7, 3, 11]):
        assert_same_truth(part.truth(row), whole.truth(seed))


def test_a_row_begins_again_while_others_go_on():
    wanted, _ = together(REAL)
    playing, frames, queue, done = np.array([0, 1, 2]), np.zeros(3, int), [3, 4, 5, 6, 7], {}
    batch = ServeBatch(REAL, casts(playing))
    batch.advance()
    while len(done) < 8:
        told = np.stack([orders(seed)[frame] for seed, frame in zip(playing, frames, strict=True)])
        over = batch.over
        batch.command(told, told=~over)
        frames += 1
        for row in np.flatnonzero(over).tolist():
            done[playing[row]] = batch.truth(row)
            if queue:
                playing[row], frames[row] = queue.pop(0), 0
                batch.restart([row], casts([playing[row]]))
        batch.advance()
    for seed, truth in done.items():
        assert_same_truth(truth, wanted.truth(int(seed)))


def test_the_state_is_the_ball_from_the_drone_in_level_axes():
    for setting in (REAL, DELAYED):
        batch = ServeBatch(setting, casts())
        for frame in range(14):
            batch.advance()
            states = batch.states()
            batch.command(np.stack([orders(seed)[frame] for seed in range(N)]))
        while not batch.over.all():
            batch.advance()
        for row, state in enumerate(states):
            told = dict(zip(STATE, state, strict=True))
            truth = batch.truth(row)
            now = round(1000 * told["time_s"])
            then = round(1000 * (told["time_s"] - told["sight_age_s"]))
            away = truth.ball_path[then - 1 : then + 1] - truth.body_path[then - 1 : then + 1]
            assert told["own_height_m"] == pytest.approx(truth.body_path[now, 2], abs=1e-12)
            assert state[2] == pytest.approx(away[1, 2], abs=1e-12)
            assert np.linalg.norm(state[:3]) == pytest.approx(np.linalg.norm(away[1]))
            speed = np.linalg.norm(away[1] - away[0]) / 0.001
            assert np.linalg.norm(state[3:6]) == pytest.approx(speed, rel=0.005)
            own = (truth.body_path[now] - truth.body_path[now - 1]) / 0.001
            assert state[8] == pytest.approx(own[2], abs=0.02)
            assert np.hypot(*state[6:8]) == pytest.approx(np.hypot(*own[:2]), abs=0.02)


def test_a_level_drone_sees_the_ball_where_it_is():
    batch = ServeBatch(Setting(TumGazebo(NOISE_FREE_CASCADE), GAZEBO), casts())
    batch.advance()
    states, ticks = batch.states(), np.rint(1000 * batch.states()[:, 16]).astype(int)
    while not batch.over.all():
        batch.advance()
    for row, state in enumerate(states):
        away = batch.truth(row).ball_path[ticks[row]] - np.array(HOME_BODY)
        assert state[:3] == pytest.approx(away, abs=1e-9)
        assert state[6:9] == pytest.approx(np.zeros(3), abs=1e-9)
        assert state[10:16] == pytest.approx(np.zeros(6), abs=1e-9)


def test_commands_are_clipped_to_the_limits_and_nan_is_refused():
    batch = ServeBatch(REAL, casts(range(2)))
    sent = batch.command(np.array([[9.0, -9.0, 9.0, -9.0], [0.5, 0.25, -0.125, 1.0]]))
    assert sent.tolist() == [[2.0, -2.0, 0.5, -1.5], [0.5, 0.25, -0.125, 1.0]]
    for bad in (np.full((2, 4), np.nan), np.array([[0.0] * 4, [0.0, np.inf, 0.0, 0.0]])):
        with pytest.raises(InputError, match="expected finite velocities"):
            batch.command(bad)
    with pytest.raises(InputError, match=r"shape \(2, 4\)"):
        batch.command(np.zeros((3, 4)))
    batch.advance()
    assert np.isfinite(batch.states()).all()


def test_a_serve_that_is_not_over_has_no_truth_and_an_empty_batch_is_refused():
    batch = ServeBatch(REAL, casts(range(2)))
    batch.advance()
    assert batch.outcomes == [None, None]
    assert np.isnan(batch.miss_distances).all()
    assert np.isnan(batch.time_errors).all()
    with pytest.raises(InputError, match="row 1 is not over"):
        batch.truth(1)
    with pytest.raises(InputError, match="at least 1"):
        ServeBatch(REAL, [])


@dataclass(frozen=True)
class Plain:
    """A user's vehicle, which knows nothing of rows."""

    limits = TUM_GAZEBO.limits
    sensor_noise = TUM_GAZEBO.sensor_noise
    name = "plain"

    def start(self, position, generator):
        return TUM_GAZEBO.start(position, generator)

    def advance(self, state, command, *, ticks, new_command):
        return TUM_GAZEBO.advance(state, command, ticks=ticks, new_command=new_command)


def test_a_vehicle_that_flies_no_rows_plays_the_same_serves():
    plain, _ = together(replace(REAL, vehicle=Plain()))
    fast, _ = together(REAL)
    for seed in range(N):
        assert_same_truth(plain.truth(seed), fast.truth(seed))
    assert np.array_equal(plain.states(), fast.states())


RACER = TumGazebo(TUM_GAZEBO.constants._replace(horizontal_limit=20.0, tilt_limit=1.2))


def test_what_was_not_looked_at_closely_could_not_have_mattered():
    """Drones that rush to where balls were, or away; the truth looks at every tick."""
    batch = ServeBatch(Setting(RACER, GAZEBO), casts())
    rush = np.array([[15.0, 0.0, 0.1, 0.0], [-15.0, 4.0, 0.2, 0.0], [0.0, 15.0, 0.3, 1.0]])
    while not batch.over.all():
        batch.advance()
        batch.command(np.resize(rush, (N, 4)))
    judged = [batch.truth(row) for row in range(N)]
    assert [truth.miss_distance for truth in judged] == batch.miss_distances.tolist()
    late = [np.nan if t.time_error is None else t.time_error for t in judged]
    assert np.array_equal(late, batch.time_errors, equal_nan=True)
    assert max(np.ptp(truth.body_path, axis=0).max() for truth in judged) > 2.0

"""The paper's player: what it flies, what it learns, what it leaves alone."""

from dataclasses import replace

import numpy as np
import pytest
from play_bench import PERIOD, BallEyes, BenchDrone, play, straight

from rotorpong.control import Departure
from rotorpong.control.plant import UNKNOWN_PLANT, Axis
from rotorpong.conventions import InputError
from rotorpong.drone import HOVER, BallEstimate, Player, VelocityCommand, Verdict
from rotorpong.experience import Attempt
from rotorpong.learning import Selection
from rotorpong.play.lessons import Lesson, reward_of
from rotorpong.play.odometer import Path
from rotorpong.play.paper import LONGEST, SHORTEST, PaperPlayer, PaperSettings
from rotorpong.primitives import State
from rotorpong.primitives.quintic import quintic_coefficients, quintic_slope, quintic_value

BALL = straight(right=0.2, down=0.1, depth=4.0, speed=6.0)
HIT = Verdict("hit", 0.4, 0.75)
MISS = Verdict("miss")


def lesson(seed):
    """A smooth motion of about half a second towards a ball of its own."""
    rng = np.random.default_rng(seed)
    ball = np.array([0.2, 0.1, 2.4, 0.0, 0.0, -6.0]) + 0.3 * rng.normal(size=6)
    duration = rng.uniform(0.35, 0.6)
    end = np.stack([0.3 * rng.normal(size=3), rng.normal(size=3) * duration, np.zeros(3)])
    target = quintic_coefficients(np.zeros((3, 3)), end)
    phase = np.linspace(0.0, 1.0, 60)[:, None]
    positions, slopes = quintic_value(target, phase), quintic_slope(target, phase)
    return Lesson(
        ball, Path(duration * phase[:, 0], positions, slopes / duration), rng.uniform(0.5, 1.0)
    )


LESSONS = tuple(lesson(seed) for seed in range(6))


@pytest.fixture
def player():
    return PaperPlayer(LESSONS)


def served(player, *, seed=0, drone=None, ball=BALL, **sight):
    """Play one serve on the bench; return the drone."""
    drone = drone or BenchDrone()
    play(player, drone, BallEyes(ball, **sight), seed=seed)
    return drone


def flown(drone, begin, end):
    """How far the commands led from `begin` to `end`: right, down, forward."""
    held = [(np.clip(end - t, 0.0, PERIOD), c) for t, c in drone.commands if t >= begin - 1e-9]
    return sum(elapsed * velocity_of(command) for elapsed, command in held)


def trigger_time(drone):
    """When the first motion began."""
    return next(t for t, command in drone.commands if command != HOVER)


def velocity_of(command):
    return np.array([-command.left, -command.up, command.forward])


def test_it_is_a_player(player):
    assert isinstance(player, Player)


@pytest.mark.parametrize("count", [0, 1])
def test_it_needs_two_demonstrations(count):
    with pytest.raises(InputError, match=f"{count} demonstrations: expected at least 2"):
        PaperPlayer(LESSONS[:count])


def test_it_hovers_until_the_ball_passes_the_plane(player):
    drone = served(player)
    crossing = next(t for t, _ in drone.commands if BALL(t)[2] < 2.5)
    before = [c for t, c in drone.commands if t < crossing]
    assert before == [HOVER] * len(before)
    assert next(c for t, c in drone.commands if t == crossing) != HOVER


def test_the_distance_trigger_asks_for_the_distance():
    off_axis = straight(right=1.5, depth=4.0, speed=6.0)
    plane, distance = (
        trigger_time(served(PaperPlayer(LESSONS, PaperSettings(trigger=kind)), ball=off_axis))
        for kind in ("plane", "distance")
    )

    assert off_axis(plane)[2] < 2.5 <= off_axis(plane - PERIOD)[2]
    assert np.linalg.norm(off_axis(distance)) < 2.5
    assert distance > plane


def test_held_commands_add_up_to_the_hitting_point_when_the_ball_is_due(player):
    drone = served(player)
    goal, begin = player.attempt(MISS).hitting_point, trigger_time(drone)
    np.testing.assert_allclose(flown(drone, begin, begin + goal[6]), goal[:3], atol=1e-9)


def test_the_commands_follow_the_motion_of_the_blended_primitives(player):
    drone = served(player)
    tried = player.attempt(MISS)
    goal = State(tried.hitting_point[:3], tried.hitting_point[3:6])
    duration = float(tried.hitting_point[6])
    blend = player.library.mix(tried.mixture_weights)
    begin = trigger_time(drone)
    steps = np.arange(int(duration / PERIOD)) * PERIOD
    still = State(np.zeros(3), np.zeros(3))
    ahead = blend.roll_out(still, goal, duration, np.append(steps, steps[-1] + PERIOD)).position
    sent = [c for t, c in drone.commands if t >= begin - 1e-9][: len(steps)]
    wanted = np.diff(ahead, axis=0) / PERIOD
    np.testing.assert_allclose([velocity_of(c) for c in sent], wanted, atol=1e-7)


def test_after_the_motion_it_hovers(player):
    drone = served(player)
    duration = player.attempt(MISS).hitting_point[6]
    begin = trigger_time(drone)
    after = [c for t, c in drone.commands if t >= begin + duration]
    assert len(after) > 5
    assert after == [HOVER] * len(after)


def test_once_it_flies_it_no_longer_looks(player):
    eyes = BallEyes(BALL)
    play(player, BenchDrone(), eyes)
    assert BALL(eyes.asked[-1])[2] < 2.5 <= BALL(eyes.asked[-2])[2]


def test_who_sees_nothing_hovers_and_has_nothing_to_learn(player):
    before = player.hitting_point(LESSONS[0].ball)
    drone = served(player, first=99.0)
    assert [c for _, c in drone.commands] == [HOVER] * 60
    assert player.attempt(HIT) is None
    player.learn(HIT)
    np.testing.assert_array_equal(player.hitting_point(LESSONS[0].ball), before)


def test_a_serve_of_no_frames_is_no_attempt(player):
    served(player)
    served(player, drone=BenchDrone(frames=0))
    assert player.attempt(HIT) is None


def test_what_was_tried_begins_with_the_ball_at_the_trigger(player):
    drone = served(player)
    tried, begin = player.attempt(MISS), trigger_time(drone)
    np.testing.assert_allclose(tried.state[:3], BALL(begin), atol=1e-12)
    np.testing.assert_allclose(tried.state[3:], [0.0, 0.0, -6.0], atol=1e-8)
    assert tried.mixture_weights.sum() == pytest.approx(1.0)
    goal = player.hitting_point(tried.state)
    np.testing.assert_allclose(tried.hitting_point, goal)


def test_a_commanded_label_is_what_was_meant_with_the_time_that_was_measured(player):
    served(player)
    meant, begin = player.attempt(MISS), 8 * PERIOD
    label = player.attempt(HIT).hitting_point
    assert BALL(begin)[2] < 2.5 <= BALL(begin - PERIOD)[2]
    np.testing.assert_array_equal(label[:6], meant.hitting_point[:6])
    assert label[6] == pytest.approx(0.75 - begin)


def test_an_achieved_label_is_what_navdata_say():
    player = PaperPlayer(LESSONS, PaperSettings(labels="achieved"))
    drone = served(player)
    begin, contact = 8 * PERIOD, 14 * PERIOD
    label = player.attempt(Verdict("hit", 0.0, contact)).hitting_point
    gone = flown(drone, begin, contact)
    held = [velocity_of(c) for _, c in drone.commands]
    slack = PERIOD * np.abs(np.diff(held, axis=0)).max() + 1e-9  # navdata turn from one to the next
    np.testing.assert_allclose(label[:3], gone, atol=slack)
    assert label[6] == pytest.approx(contact - begin)
    assert not np.allclose(label[:3], player.attempt(MISS).hitting_point[:3])


@pytest.mark.parametrize("labels", ["commanded", "achieved"])
def test_a_contact_before_the_trigger_is_no_label(labels):
    player = PaperPlayer(LESSONS, PaperSettings(labels=labels))
    served(player)
    early = player.attempt(Verdict("hit", 0.0, 0.01))
    assert early == player.attempt(MISS)


@pytest.mark.parametrize("outcome", ["miss", "hull", "fault", "near_hit", "unseen"])
def test_it_learns_from_hits_only(player, outcome):
    drone = served(player)
    player.learn(Verdict(outcome))
    again = served(player)
    assert again.commands == drone.commands


def test_after_a_hit_it_expects_to_be_nearer_to_where_it_hit():
    player = PaperPlayer(LESSONS, explore=True)
    for seed in range(5):
        served(player, seed=seed)
        tried = player.attempt(HIT)
        before = np.abs(player.hitting_point(tried.state) - tried.hitting_point)
        player.learn(HIT)
        after = np.abs(player.hitting_point(tried.state) - tried.hitting_point)
        off = before > 1e-9  # velocities are not explored: there is nothing to learn about them
        assert off[[0, 1, 2, 6]].all()
        assert np.all(after[off] < before[off])
        np.testing.assert_allclose(after[~off], 0.0, atol=1e-12)


def test_a_well_hit_ball_teaches_more_than_a_rim_shot():
    moved = []
    for offset in (0.0, 1.0):
        player = PaperPlayer(LESSONS)
        served(player)
        verdict = Verdict("hit", offset, 0.5)
        state = player.attempt(verdict).state
        before = player.hitting_point(state)
        player.learn(verdict)
        moved.append(np.linalg.norm(player.hitting_point(state) - before))
    assert moved[0] > moved[1] > 0.0


def test_a_hit_is_worth_believing_in_for_the_primitives_that_took_part(player):
    served(player)
    tried = player.attempt(HIT)
    best = int(np.argmax(tried.mixture_weights))
    credit = np.eye(len(LESSONS))[best]
    for _ in range(3):
        player.remember(Attempt(tried.state, tried.hitting_point, credit), 1.0)
        player.remember(Attempt(tried.state, tried.hitting_point, 1.0 - credit), 0.0)
    served(player)
    weights = player.attempt(MISS).mixture_weights
    assert int(np.argmax(weights)) == best
    assert weights[best] > tried.mixture_weights[best]


def test_what_is_remembered_does_not_depend_on_the_order():
    rng = np.random.default_rng(3)
    kept = [
        (Attempt(one.ball + 0.1 * rng.normal(size=6), one.hitting_point, rng.dirichlet(np.ones(6))),
         one.reward)
        for one in map(lesson, range(20, 32))
    ]  # fmt: skip
    forward, backward = PaperPlayer(LESSONS), PaperPlayer(LESSONS)
    for attempt, reward in kept:
        forward.remember(attempt, reward)
    for attempt, reward in reversed(kept):
        backward.remember(attempt, reward)
    ball = LESSONS[0].ball + 0.05
    np.testing.assert_allclose(
        forward.hitting_point(ball), backward.hitting_point(ball), rtol=0, atol=1e-9
    )
    served(forward), served(backward)
    np.testing.assert_allclose(
        forward.attempt(MISS).mixture_weights, backward.attempt(MISS).mixture_weights, atol=1e-9
    )


def test_near_its_demonstrations_it_does_as_demonstrated():
    exact = PaperPlayer(LESSONS, PaperSettings(regularization=1e-9, length_scale=1.0))
    for one in LESSONS:
        np.testing.assert_allclose(exact.hitting_point(one.ball), one.hitting_point, atol=1e-5)


def test_far_from_all_it_knows_it_does_the_mean_of_its_demonstrations(player):
    mean = np.mean([one.hitting_point for one in LESSONS], axis=0)
    np.testing.assert_allclose(player.hitting_point(LESSONS[0].ball + 1e3), mean, atol=1e-12)


def test_exploring_varies_where_the_blade_goes_and_nothing_else():
    plain, curious = PaperPlayer(LESSONS), PaperPlayer(LESSONS, explore=True)
    served(plain)
    goal = plain.attempt(MISS).hitting_point
    tries = []
    for seed in range(200):
        served(curious, seed=seed, drone=BenchDrone(frames=10))
        tries.append(curious.attempt(MISS).hitting_point - goal)
    tries = np.array(tries)
    np.testing.assert_array_equal(tries[:, 3:], 0.0)
    np.testing.assert_allclose(tries[:, :3].std(axis=0), 0.10, atol=4 * 0.10 / np.sqrt(2 * 200))
    np.testing.assert_allclose(tries[:, :3].mean(axis=0), 0.0, atol=4 * 0.10 / np.sqrt(200))


def test_who_does_not_explore_throws_no_dice(player):
    rng = np.random.default_rng(0)
    player.play(BenchDrone(), BallEyes(BALL), rng)
    assert rng.random() == np.random.default_rng(0).random()


def test_the_same_dice_give_the_same_game():
    games = [served(PaperPlayer(LESSONS, explore=True), seed=s).commands for s in (1, 1, 2)]
    assert games[0] == games[1]
    assert games[0] != games[2]


def test_nothing_is_carried_from_serve_to_serve(player):
    alone = served(PaperPlayer(LESSONS)).commands
    served(player, ball=straight(right=-0.5, down=-0.3, speed=8.0))
    assert served(player).commands == alone


@pytest.mark.parametrize(("duration", "kept"), [(0.01, SHORTEST), (9.0, LONGEST)])
def test_a_motion_is_never_shorter_or_longer_than_a_drone_can_fly(duration, kept):
    def stretched(one):
        times = one.path.times * duration / one.path.times[-1]
        return Lesson(one.ball, Path(times, one.path.positions, one.path.velocities), one.reward)

    player = PaperPlayer([stretched(one) for one in LESSONS])
    drone = served(player)
    assert player.attempt(MISS).hitting_point[6] == kept
    sent = np.array([[c.forward, c.left, c.up] for _, c in drone.commands])
    assert np.isfinite(sent).all()


def test_a_flying_start_goes_on_as_it_flies(player):
    moving = BenchDrone(frames=30, start=VelocityCommand(0.5, 0.0, 0.0))
    near = straight(depth=2.4, speed=6.0)
    play(player, moving, BallEyes(near))
    still = served(PaperPlayer(LESSONS), drone=BenchDrone(frames=30), ball=near)
    assert moving.commands[0][1].forward > still.commands[0][1].forward + 0.3


def test_with_late_pictures_the_motion_counts_from_the_exposure(player):
    drone = served(player, drone=BenchDrone(delay=2 * PERIOD))
    prompt = PaperPlayer(LESSONS)
    on_time = served(prompt)
    begin = next(i for i, (_, c) in enumerate(on_time.commands) if c != HOVER)
    late = [c for _, c in drone.commands][begin + 2 :]
    soon = [c for _, c in on_time.commands][begin + 2 :]
    np.testing.assert_allclose(
        [velocity_of(c) for c in late][:5], [velocity_of(c) for c in soon][:5], atol=1e-7
    )


def test_a_choosing_rule_flies_one_primitive():
    player = PaperPlayer(LESSONS, PaperSettings(selection=Selection("greedy")))
    served(player)
    np.testing.assert_array_equal(np.sort(player.attempt(MISS).mixture_weights), [0.0] * 5 + [1.0])


def test_thompson_throws_the_serve_s_dice():
    player = PaperPlayer(LESSONS, PaperSettings(selection=Selection("thompson")))
    chosen = set()
    for seed in range(30):
        served(player, seed=seed, drone=BenchDrone(frames=10))
        chosen.add(int(np.argmax(player.attempt(MISS).mixture_weights)))
    assert len(chosen) > 1


def test_who_learns_from_misses_doubts_what_missed_and_moves_no_hitting_point():
    settings = PaperSettings(selection=Selection("greedy"), learn_from_misses=True)
    player = PaperPlayer(LESSONS, settings)
    served(player)
    tried = player.attempt(MISS)
    before = player.hitting_point(tried.state)
    for _ in range(5):
        player.learn(MISS)
    served(player)
    assert not np.array_equal(player.attempt(MISS).mixture_weights, tried.mixture_weights)
    np.testing.assert_array_equal(player.hitting_point(tried.state), before)


def test_a_thrower_s_fault_is_nobody_s_miss():
    player = PaperPlayer(LESSONS, PaperSettings(learn_from_misses=True))
    drone = served(player)
    player.learn(Verdict("fault"))
    assert served(player).commands == drone.commands


def test_what_is_recalled_is_what_was_learnt():
    settings = PaperSettings(learn_from_misses=True, tune=True)
    played, told = PaperPlayer(LESSONS, settings), PaperPlayer(LESSONS, settings)
    for seed in range(12):
        served(played, seed=seed, ball=straight(right=0.1 * seed, depth=4.0, speed=6.0))
        verdict = HIT if seed % 2 else MISS
        attempt = played.attempt(verdict)
        played.learn(verdict)
        told.recall(verdict.outcome, attempt, reward_of(verdict))
    assert served(played).commands == served(told).commands


def test_a_tuned_player_finds_which_of_its_inputs_matter():
    rng = np.random.default_rng(0)

    def related(one):
        shift = one.ball[0] - LESSONS[0].ball[0]  # only where the ball is, sideways, matters
        path = one.path
        positions = path.positions + shift * np.linspace(0.0, 1.0, len(path.times))[:, None]
        return Lesson(one.ball, Path(path.times, positions, path.velocities), 1.0)

    lessons = []
    for _ in range(30):
        ball = LESSONS[0].ball + 0.3 * rng.normal(size=6)
        lessons.append(related(Lesson(ball, LESSONS[0].path, 1.0)))
    errors = []
    for tune in (False, True):
        player = PaperPlayer(lessons[:20], PaperSettings(tune=tune))
        found = np.array([player.hitting_point(one.ball) for one in lessons[20:]])
        wanted = np.array([one.hitting_point for one in lessons[20:]])
        errors.append(np.abs(found - wanted)[:, :3].mean())
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("control", ["open", "feed_forward", "closed_loop"])
def test_a_stroke_ends_where_and_when_it_is_meant_to_however_it_is_flown(control):
    """On a drone that flies exactly as it is told, with nothing to lag behind."""
    plant = replace(UNKNOWN_PLANT, axes=(Axis(1e-3),) * 3)
    player = PaperPlayer(LESSONS, PaperSettings(control=control, plant=plant))
    drone = served(player)
    goal, begin = player.attempt(MISS).hitting_point, trigger_time(drone)
    np.testing.assert_allclose(flown(drone, begin, begin + goal[6]), goal[:3], atol=0.01)


def test_the_open_loop_is_what_is_flown_unless_asked_otherwise():
    usual, asked = (served(PaperPlayer(LESSONS, s)) for s in (None, PaperSettings(control="open")))
    assert usual.commands == asked.commands
    ahead = served(PaperPlayer(LESSONS, PaperSettings(control="feed_forward"))).commands
    assert max(c.forward**2 + c.left**2 for _, c in ahead) > max(
        c.forward**2 + c.left**2 for _, c in usual.commands
    )


def test_a_departing_stroke_arrives_when_it_would_have_arrived():
    player = PaperPlayer(LESSONS)
    served(player)
    seen = BallEstimate(0.5, np.array([0.2, 0.1, 2.4]), np.array([0.0, 0.0, -6.0]), np.eye(6))
    stroke = player.stroke(seen, np.array([0.2, 0.1, 0.0, 0.5, 0.0, 0.0, 0.6]), np.zeros(3))
    gone = np.array([0.01, 0.0, 0.0])
    departure = Departure(stroke.begin + 0.1, np.array([0.02, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]))
    later = stroke.departing(departure, gone)
    assert later.course.end == pytest.approx(stroke.course.end)
    first, last = later.course.at(np.array([departure.time, later.course.end]))[0]
    np.testing.assert_allclose(first, departure.position, atol=1e-12)
    np.testing.assert_allclose(last + gone, stroke.goal[:3], atol=1e-9)
    assert np.abs(later.course.at(np.array([departure.time]))[2]).max() < 1e-9

import numpy as np
import pytest
from noise_samples import normal_samples, slow_samples
from scipy import stats

from rotorpong.physics._noise_kernels import uniform
from rotorpong.physics.noise import draw_keys


def splitmix64(seed, count):
    """Plain integers, after the published algorithm."""
    mask = 2**64 - 1
    outputs = []
    for _ in range(count):
        seed = (seed + 0x9E3779B97F4A7C15) & mask
        z = ((seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        outputs.append(z ^ (z >> 31))
    return outputs


def test_uniform_numbers_are_the_top_bits_of_splitmix64():
    key = 0xFEDCBA9876543210
    expected = [(z >> 11) * 2.0**-53 for z in splitmix64(key, 50)]
    assert [uniform(np.uint64(key), i) for i in range(50)] == expected


def test_splitmix64_starts_with_its_published_first_number():
    assert splitmix64(0, 1) == [0xE220A8397B1DCDAF]


def test_normal_samples_are_normal_and_their_channels_unrelated():
    samples = normal_samples(draw_keys(np.random.default_rng(3)), 0, (20_000, 3))
    assert stats.kstest(samples.ravel(), "norm").pvalue > 1e-3
    assert np.abs(np.corrcoef(samples.T) - np.eye(3)).max() < 4 / np.sqrt(20_000)  # 4 sigma
    assert abs(np.corrcoef(samples[1:, 0], samples[:-1, 0])[0, 1]) < 4 / np.sqrt(20_000)


@pytest.mark.parametrize("cut", [0, 1, 7, 20])
def test_samples_do_not_depend_on_the_portions_they_are_asked_in(cut):
    key = draw_keys(np.random.default_rng(1))
    whole = normal_samples(key, 5, (20, 4))
    parts = [normal_samples(key, 5, (cut, 4)), normal_samples(key, 5 + cut, (20 - cut, 4))]
    assert np.array_equal(np.concatenate(parts), whole)


def test_many_keys_are_the_keys_drawn_one_by_one():
    one_by_one = np.random.default_rng(7)
    assert np.array_equal(
        draw_keys(np.random.default_rng(7), (5,)), [draw_keys(one_by_one) for _ in range(5)]
    )


def test_neighbouring_keys_give_unrelated_samples():
    a, b = (normal_samples(np.array(k, np.uint64), 0, (10_000, 1))[:, 0] for k in (10, 11))
    assert abs(np.corrcoef(a, b)[0, 1]) < 4 / np.sqrt(10_000)


def test_slow_samples_are_stationary_and_forget_by_their_correlation_time():
    """4 sigma; a lag of one correlation time leaves 1/e, and paths are independent."""
    times = np.linspace(0.0, 10.0, 21)
    keys = draw_keys(np.random.default_rng(4), (4000,))
    paths = np.array([slow_samples(np.asarray(key), times, 5.0, 1)[:, 0] for key in keys])
    assert paths.mean(axis=0) == pytest.approx(0.0, abs=4 / np.sqrt(4000))
    assert paths.var(axis=0) == pytest.approx(1.0, abs=4 * np.sqrt(2 / 4000) + 0.01)
    for first, last, expected in ((0, 10, np.exp(-1)), (7, 17, np.exp(-1)), (0, 20, np.exp(-2))):
        found = np.mean(paths[:, first] * paths[:, last])
        assert found == pytest.approx(expected, abs=4 * np.sqrt((1 + expected**2) / 4000) + 0.01)


def test_slow_samples_follow_the_recursion_of_their_process():
    key, decay = np.asarray(np.uint64(99)), np.exp(-1 / 50)
    nodes = slow_samples(key, np.arange(30) * 0.1, 5.0, 2)
    drawn = normal_samples(key, 0, (30, 2))
    expected = [drawn[0]]
    for fresh in drawn[1:]:
        expected.append(decay * expected[-1] + np.sqrt(1 - decay**2) * fresh)
    assert nodes == pytest.approx(np.array(expected), abs=1e-9)


@pytest.mark.parametrize("cut", [0, 3, 40])
def test_slow_samples_do_not_depend_on_the_portions_they_are_asked_in(cut):
    key, times = draw_keys(np.random.default_rng(1)), np.arange(40) * 0.013
    parts = [slow_samples(key, times[:cut], 0.4, 2), slow_samples(key, times[cut:], 0.4, 2)]
    assert np.array_equal(np.concatenate(parts), slow_samples(key, times, 0.4, 2))

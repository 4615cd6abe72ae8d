"""A trial acknowledged is a trial kept, whatever happens to the process, the disk or the file."""

import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rotorpong.conventions import StoreError
from rotorpong.drone import OUTCOMES
from rotorpong.experience import Attempt, Demonstration, Run, Trial, create, open_store
from rotorpong.experience.database import seal
from rotorpong.experience.truth import TruthRow, record, truth_rows

RUN = Run(
    1,
    7,
    *("paper", "truth", "tum_gazebo", "gazebo", "human", "0.1.0", "scripted"),
    {"hits": 80, "labels": "commanded", "noise_m": 0.1},
)
finite = st.floats(allow_nan=False, allow_infinity=False)

WRITER = """
import sys
from pathlib import Path
sys.path.insert(0, {folder!r})
from rotorpong.experience import create, open_store
from test_experience_store import RUN, demonstrations, trial, truth
from rotorpong.experience.truth import record

path = Path(sys.argv[1])
while True:
    with open_store(path) if path.exists() else create(path, RUN) as store:
        store.add_demonstrations(demonstrations())
        first = store.count()
        for index in range(first, first + 7):
            store.add_trial(trial(index), record(truth(index)))
            print(index, flush=True)
"""


def trial(index):
    """Return what a run with RUN's seed gives at `index`, whoever asks and how often."""
    rng = np.random.default_rng([RUN.seed, index])
    if index % 3 == 0:
        return Trial(index, "miss", 0.0, None, None, None)
    attempt = Attempt(rng.normal(size=6), rng.normal(size=7), rng.random(10))
    return Trial(index, "hit", rng.random(), attempt, rng.random(), rng.random())


def truth(index):
    rng = np.random.default_rng([RUN.seed, index, 1])
    return TruthRow(index, rng.random(), rng.normal(), None, *rng.normal(size=(3, 3)))


def demonstrations():
    rng = np.random.default_rng(RUN.seed)
    times = np.arange(30) / 30.0
    spec = {"vehicle": "tum_gazebo", "serves": "human", "balls": 1, "raw": False, "wind": None}
    return tuple(
        Demonstration(0, i, spec, "scripted", np.c_[times, rng.normal(size=(30, 4))])
        for i in range(3)
    )


def fill(path, count):
    with create(path, RUN) as store:
        store.add_demonstrations(demonstrations())
        play(store, range(count))
    return path


def play(store, indices):
    for index in indices:
        store.add_trial(trial(index), record(truth(index)))


def everything(path):
    return read_through(path, readonly=True)


def read_through(path, *, readonly):
    with open_store(path, readonly=readonly) as store:
        return store.run, store.demonstrations(), store.trials(), truth_rows(store), store.count()


def answer(path):
    """Return the rows as they were, or the error as text."""
    try:
        return everything(path)
    except StoreError as error:
        return str(error)


def raw_rows(path):
    """Return every row of every table, past our own code."""
    with closing(sqlite3.connect(path)) as connection:
        only = "WHERE type = 'table'"
        tables = [name for (name,) in connection.execute(f"SELECT name FROM sqlite_master {only}")]
        return {name: connection.execute(f"SELECT * FROM {name}").fetchall() for name in tables}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.sqlite"


@pytest.fixture(scope="module")
def example(tmp_path_factory):
    return fill(tmp_path_factory.mktemp("store") / "example.sqlite", 20)


@pytest.fixture
def copy(example, path):
    return Path(shutil.copy(example, path))


@contextmanager
def edited(path):
    with closing(sqlite3.connect(path)) as connection, connection:
        yield connection


@st.composite
def trials(draw):
    attempt = None
    if draw(st.booleans()):
        shapes = (6, 7, draw(st.integers(1, 12)))
        attempt = Attempt(*(draw(arrays(float, n, elements=finite)) for n in shapes))
    maybe = st.none() | finite
    index = draw(st.integers(0, 2**63 - 1))
    outcome = draw(st.sampled_from(OUTCOMES))
    return Trial(index, outcome, draw(finite), attempt, draw(maybe), draw(maybe))


@settings(deadline=None, max_examples=30)
@given(st.lists(trials(), max_size=4, unique_by=lambda one: one.index))
def test_trials_come_back_bit_for_bit_by_index(written):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.sqlite")
        with create(path, RUN) as store:
            assert [store.add_trial(one) for one in written] == [True] * len(written)
        with open_store(path, readonly=True) as store:
            read = store.trials()
            assert truth_rows(store) == ()
    assert repr(read) == repr(tuple(sorted(written, key=lambda one: one.index)))
    for one, two in zip(sorted(written, key=lambda one: one.index), read, strict=True):
        if one.attempt is not None:
            assert one.attempt.hitting_point.tobytes() == two.attempt.hitting_point.tobytes()
            assert two.attempt.hitting_point.flags.writeable


def test_run_demonstrations_and_truth_come_back(example):
    run, shown, tried, true, count = everything(example)
    assert run == RUN
    assert shown == demonstrations()
    assert tried == tuple(trial(i) for i in range(20))
    assert true == tuple(truth(i) for i in range(20))
    assert count == 20


def test_an_independent_reader_finds_plain_sqlite_with_little_endian_float64(example):
    with closing(sqlite3.connect(example)) as connection:
        state, reward, offset = connection.execute(
            "SELECT state, reward, contact_offset FROM trials WHERE trial = 1"
        ).fetchone()
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    expected = trial(1)
    assert (reward, offset) == (expected.reward, expected.contact_offset)
    assert np.array_equal(np.frombuffer(state, "<f8"), expected.attempt.state)


def test_the_same_run_gives_the_same_bytes_in_every_row(tmp_path):
    one, two = (fill(tmp_path / name, 6) for name in ("one.sqlite", "two.sqlite"))
    assert raw_rows(one) == raw_rows(two)


def test_adding_a_trial_again_changes_nothing(copy):
    before = raw_rows(copy)
    with open_store(copy) as store:
        store.add_demonstrations(demonstrations())
        assert not store.add_trial(trial(4), record(truth(4)))
    assert raw_rows(copy) == before


def test_another_trial_under_a_kept_index_is_refused_and_the_kept_one_stays(copy):
    with open_store(copy) as store:
        with pytest.raises(StoreError, match=r"trials \(1, 4\) is kept with other values"):
            store.add_trial(replace(trial(4), reward=0.125))
        with pytest.raises(StoreError, match="demonstrations"):
            store.add_demonstrations(demonstrations()[::-1])
        assert store.add_trial(trial(20))
        assert store.trials() == tuple(trial(i) for i in range(21))


def test_a_trial_whose_truth_cannot_be_kept_is_not_kept_either(copy):
    with open_store(copy) as store:
        with pytest.raises(StoreError, match="FOREIGN KEY"):
            store.add_trial(trial(20), record(truth(21)))
        assert store.count() == 20
        assert store.add_trial(trial(20), record(truth(20)))
        assert truth_rows(store)[-1] == truth(20)


def test_another_run_is_refused_naming_the_fields_that_differ(example):
    with open_store(example, readonly=True) as store:
        store.check_run(replace(RUN, spec=dict(reversed(RUN.spec.items()))))
        other = replace(RUN, eyes="paper", spec={**RUN.spec, "hits": 90, "spin": 1})
        with pytest.raises(StoreError) as caught:
            store.check_run(other)
    for words in ('eyes is "truth", given "paper"', "hits is 80, given 90", "spin is absent"):
        assert words in str(caught.value)
    assert "player" not in str(caught.value)


def test_kill_9_at_any_moment_loses_no_acknowledged_trial(path):
    script = WRITER.format(folder=str(Path(__file__).parent))
    rng = np.random.default_rng(0)
    acknowledged = -1
    for _ in range(6):
        command = [sys.executable, "-c", script, str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
            for _ in range(rng.integers(1, 60)):
                acknowledged = int(child.stdout.readline())
            with pytest.raises(subprocess.TimeoutExpired):
                child.wait(rng.uniform(0, 0.02))
            child.send_signal(signal.SIGKILL)
            acknowledged = max([acknowledged, *map(int, child.stdout.read().split())])
        count = everything(path)[-1]
        assert count > acknowledged
    with open_store(path) as store:
        store.add_trial(trial(count), record(truth(count)))
    assert raw_rows(path) == raw_rows(fill(path.with_name("uninterrupted.sqlite"), count + 1))


def test_a_child_killed_while_creating_leaves_a_whole_file_or_none(path):
    for number in range(12):
        child = os.fork()
        if child == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)  # dies on the spot
            signal.setitimer(signal.ITIMER_REAL, 0.0004 * (number + 1))
            try:
                create(path, RUN)
            finally:
                os.kill(os.getpid(), signal.SIGKILL)
        os.waitpid(child, 0)
        if path.exists():
            assert everything(path)[0] == RUN
            path.unlink()


def test_a_full_disk_is_a_clear_error_and_what_was_kept_stays(copy):
    with open_store(copy) as store:
        pages = store.connection.execute("PRAGMA page_count").fetchone()[0]
        store.connection.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(StoreError, match="the disk is full"):
            play(store, range(20, 400))
        kept = store.count()
        assert 20 <= kept < 400
        store.connection.execute("PRAGMA max_page_count = 100000")
        assert store.add_trial(trial(kept), record(truth(kept)))
    assert everything(copy)[2] == tuple(trial(i) for i in range(kept + 1))


def test_a_file_size_limit_loses_nothing_that_was_acknowledged(copy):
    script = WRITER.format(folder=str(Path(__file__).parent))
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, -1))\n"
    command = [sys.executable, "-c", limit + script, str(copy)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "StoreError" in result.stderr
    assert "the disk is full or failing" in result.stderr.splitlines()[-1]
    assert everything(copy)[2] == tuple(trial(i) for i in range(everything(copy)[-1]))
    assert everything(copy)[-1] > int(result.stdout.split()[-1])


def test_readers_read_while_a_writer_writes(copy):
    with open_store(copy) as writer, open_store(copy, readonly=True) as reader:
        for index in range(20, 30):
            writer.add_trial(trial(index))
            assert reader.count() == index + 1
            assert everything(copy)[-1] == index + 1
        with pytest.raises(StoreError, match="reading only"):
            reader.add_trial(trial(30))


def test_a_second_writer_is_refused_and_the_first_goes_on(copy):
    with open_store(copy) as first:
        with pytest.raises(StoreError, match="another process is using it"):
            open_store(copy)
        first.add_trial(trial(20))
    with open_store(copy) as second:
        assert second.count() == 21


def test_a_closed_file_is_complete_in_itself(copy):
    with open_store(copy) as store:
        store.add_trial(trial(20))
    assert list(copy.parent.iterdir()) == [copy]
    elsewhere = Path(shutil.copy(copy, copy.with_name("elsewhere.sqlite")))
    assert everything(elsewhere)[-1] == 21


def test_closing_beside_a_reader_loses_nothing_and_the_next_writer_folds_the_log(copy):
    with open_store(copy, readonly=True) as reader:
        with open_store(copy) as store:
            store.add_trial(trial(20))
        assert reader.count() == 21
    with open_store(copy) as store:
        assert store.count() == 21
    assert list(copy.parent.iterdir()) == [copy]


@pytest.mark.parametrize("state", ["closed", "wal", "killed"])
def test_a_read_only_medium_can_be_read_and_is_not_written(example, state):
    with _medium() as folder:
        copy = Path(shutil.copy(example, folder / "run.sqlite"))
        if state == "wal":
            with closing(sqlite3.connect(copy)) as connection:
                connection.execute("PRAGMA journal_mode = WAL")
        if state == "killed" and (child := os.fork()) == 0:
            try:
                open_store(copy).add_trial(trial(20))
            finally:
                os.kill(os.getpid(), signal.SIGKILL)
        elif state == "killed":
            os.waitpid(child, 0)
        with _forbidden(folder):
            assert everything(copy)[-1] == (21 if state == "killed" else 20)
            with pytest.raises(StoreError, match="cannot be written"):
                open_store(copy)
            with pytest.raises(StoreError, match="permission"):
                create(folder / "new.sqlite", RUN)


@contextmanager
def _medium():
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


@contextmanager
def _forbidden(folder):
    """Take the permission to write away, from root by being nobody for a while."""
    for file in folder.iterdir():
        file.chmod(0o444)
    folder.chmod(0o555)
    user = os.geteuid()
    if user == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(user)
        folder.chmod(0o755)


def test_damaged_bytes_give_an_error_or_the_same_rows(example, path):
    rng = np.random.default_rng(0)
    good, data = everything(example), example.read_bytes()
    answers = []
    for _ in range(400):
        damaged = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            damaged[rng.integers(len(data))] ^= 1 << rng.integers(8)
        length = rng.choice([len(data), len(data), rng.integers(len(data))])
        path.write_bytes(damaged[:length])
        answers.append(answer(path))
    errors = [given for given in answers if given != good]
    assert 50 < len(errors) < 350
    assert all(error.startswith(f"{path}: ") and "\n" not in error for error in errors)


def test_every_bit_of_a_row_is_under_its_seal(copy):
    blob = trial(4).attempt.state.tobytes()
    start = copy.read_bytes().index(blob)
    for offset in range(0, len(blob), 7):
        data = bytearray(copy.read_bytes())
        data[start + offset] ^= 1
        copy.write_bytes(data)
        with pytest.raises(StoreError, match=r"damaged: trials \(1, 4\) does not match its seal"):
            everything(copy)
        data[start + offset] ^= 1
        copy.write_bytes(data)


@pytest.mark.parametrize("column", ["state", "hitting_point", "mixture_weights"])
def test_a_sealed_row_with_a_blob_of_the_wrong_length_is_an_error(copy, column):
    with edited(copy) as connection:
        connection.execute(f"UPDATE trials SET {column} = x'0102030405' WHERE trial = 4")
        (*row, _) = connection.execute("SELECT * FROM trials WHERE trial = 4").fetchone()
        mark = seal("trials", tuple(row))
        connection.execute("UPDATE trials SET seal = ? WHERE trial = 4", (mark,))
    with pytest.raises(StoreError, match="5 bytes where float64"):
        everything(copy)


@pytest.mark.parametrize(
    ("statement", "named"),
    [
        ("PRAGMA application_id = 5", "not an experience file: its application id is 5"),
        ("PRAGMA user_version = 2", "format 2; this rotorpong reads format 1: upgrade"),
        ("PRAGMA user_version = 0", "format 0; this rotorpong reads format 1"),
        ("DROP TABLE demonstrations", "foreign or damaged layout"),
        ("ALTER TABLE trials ADD COLUMN score", "foreign or damaged layout"),
        ("CREATE TABLE notes(text)", "foreign or damaged layout"),
        ("CREATE TRIGGER t AFTER INSERT ON trials BEGIN SELECT 1; END", "layout"),
        ("DELETE FROM runs", "0 runs; expected one"),
        ("UPDATE trials SET reward = 0.9 WHERE trial = 4", "does not match its seal"),
        ("UPDATE truth_trials SET miss_distance_m = 0", "does not match its seal"),
    ],
)
@pytest.mark.parametrize("readonly", [True, False])
def test_a_foreign_or_edited_file_is_refused_and_left_as_it_was(copy, statement, named, readonly):
    with edited(copy) as connection:
        connection.execute(statement)
    before = raw_rows(copy)
    with pytest.raises(StoreError, match=named):
        read_through(copy, readonly=readonly)
    assert raw_rows(copy) == before


@pytest.mark.parametrize("content", [b"", b"x", b"time_s,x_m\n0,1\n" * 500, bytes(8192)])
@pytest.mark.parametrize("readonly", [True, False])
def test_what_is_not_sqlite_is_refused_and_left_alone(path, content, readonly):
    path.write_bytes(content)
    with pytest.raises(StoreError, match="not an experience file"):
        open_store(path, readonly=readonly)
    assert path.read_bytes() == content
    assert list(path.parent.iterdir()) == [path]


def test_an_existing_file_is_never_overwritten(copy):
    before = copy.read_bytes()
    with pytest.raises(StoreError, match="exists; use --resume"):
        create(copy, RUN)
    assert copy.read_bytes() == before
    assert list(copy.parent.iterdir()) == [copy]


def test_folders_and_missing_files_are_named(tmp_path):
    with pytest.raises(StoreError, match="is a folder"):
        open_store(tmp_path)
    with pytest.raises(StoreError, match="exists"):
        create(tmp_path, RUN)
    with pytest.raises(StoreError, match="does not exist"):
        open_store(tmp_path / "none.sqlite")
    with pytest.raises(StoreError, match="does not exist"):
        create(tmp_path / "none" / "run.sqlite", RUN)
    assert list(tmp_path.iterdir()) == []


def test_awkward_names_are_just_names(tmp_path):
    for name in ("a b?mode=ro#%41.sqlite", "größe.sqlite", "-.sqlite"):
        fill(tmp_path / name, 1)
        assert everything(tmp_path / name)[-1] == 1
    assert len(list(tmp_path.iterdir())) == 3


def test_the_store_reaches_neither_truth_nor_the_simulator():
    code = "import sys, rotorpong.experience; print(*sorted(sys.modules))"
    command = [sys.executable, "-c", code]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    assert "rotorpong.experience.store" in loaded
    for name in ("rotorpong.experience.truth", "rotorpong.world", "numba", "cv2", "matplotlib"):
        assert name not in loaded


def test_a_closed_store_says_so(copy):
    store = open_store(copy)
    store.close()
    store.close()
    with pytest.raises(StoreError, match="closed"):
        store.count()

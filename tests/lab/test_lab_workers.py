"""Work shared out: in order, never lost, never orphaned."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rotorpong.conventions import InputError, RotorpongError
from rotorpong.lab.workers import in_workers

BOSS = """
import os, sys, time
from rotorpong.lab.workers import in_workers
from test_lab_workers import begin, sleep

if __name__ == "__main__":
    try:
        for _ in in_workers(sleep, [60.0] * 4, workers=2, begin=begin, arguments=(sys.argv[1],)):
            pass
    except KeyboardInterrupt:
        print("interrupted", flush=True)
"""


def begin(folder):
    """Leave a mark that this worker runs."""
    Path(folder, str(os.getpid())).touch()


def square(number):
    return number * number


def sleep(seconds):
    time.sleep(seconds)


def refuse(number):
    if number == 3:
        raise InputError("three")
    sys.stdout.write("never on stdout\n")
    return number


def die(number):
    os._exit(number)


def shared(function, tasks, folder, workers=2):
    return list(in_workers(function, tasks, workers=workers, begin=begin, arguments=(folder,)))


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return not is_zombie(pid)


def is_zombie(pid):
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"


def wait_until(condition, seconds=60.0):
    for _ in range(int(seconds / 0.05)):
        if condition():
            return True
        time.sleep(0.05)
    return False


@pytest.fixture
def boss(tmp_path):
    """A process with two workers, all of them at work."""
    (tmp_path / "boss.py").write_text(BOSS)
    marks = tmp_path / "marks"
    marks.mkdir()
    place = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen(
        [sys.executable, "boss.py", str(marks)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": place},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert wait_until(lambda: len(list(marks.iterdir())) == 2)
    yield process, [int(mark.name) for mark in marks.iterdir()]
    process.kill()
    process.communicate()


def test_answers_come_in_the_order_of_the_tasks(tmp_path):
    assert shared(square, list(range(9)), str(tmp_path)) == [n * n for n in range(9)]
    assert 1 <= len(list(tmp_path.iterdir())) <= 2


def test_an_error_in_a_worker_is_the_callers_and_prints_stay_off_stdout(tmp_path, capfd):
    with pytest.raises(InputError, match="three"):
        shared(refuse, [1, 2, 3, 4], str(tmp_path))
    said = capfd.readouterr()
    assert said.out == ""
    assert "never on stdout" in said.err


def stumble(folder):
    raise InputError(f"no seat in {folder}")


def test_an_error_at_the_beginning_of_a_worker_is_the_callers(capfd):
    with pytest.raises(InputError, match="no seat in the room"):
        list(in_workers(square, [1, 2, 3], workers=2, begin=stumble, arguments=("the room",)))
    assert capfd.readouterr().err == ""


def test_a_worker_that_dies_is_reported(tmp_path):
    with pytest.raises(RotorpongError, match="a worker process died"):
        shared(die, [1, 1], str(tmp_path))


def test_ctrl_c_ends_all_workers_at_once_and_quietly(boss):
    process, workers = boss
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err) == (0, "interrupted\n", "")
    assert not any(map(is_alive, workers))


def test_workers_do_not_outlive_a_killed_parent(boss):
    process, workers = boss
    assert all(map(is_alive, workers))
    process.kill()
    process.wait()
    assert wait_until(lambda: not any(map(is_alive, workers)), 10.0)

"""Whatever is written is there whole or not at all, in place of regular files only."""

import contextlib
import errno
import os
import resource
from pathlib import Path

import cv2
import numpy as np
import pytest
from test_cli import ask, complaint

from rotorpong.conventions import InputError, StoreError
from rotorpong.experience.shipped import shipped_demonstrations, write_demonstrations
from rotorpong.files import prepare_folder, put, replacing, target_of, write_whole
from rotorpong.lab.demo_files import FILES, finished_together
from rotorpong.lab.spec import Spec
from rotorpong.lab.throw import throw

FLIGHT = Path(__file__).resolve().parents[1] / "examples" / "flight.csv"


@contextlib.contextmanager
def full_after(size):
    """A disk on which no file grows beyond `size` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a pipe, a file, and links to them."""
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.png")
    (tmp_path / "folder").mkdir()
    (tmp_path / "old.csv").write_text("old")
    (tmp_path / "to_pipe.csv").symlink_to("pipe.png")
    (tmp_path / "to_old.csv").symlink_to("old.csv")
    (tmp_path / "to_new.csv").symlink_to("folder/new.csv")
    (tmp_path / "circle.csv").symlink_to("circle.csv")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pipe.png", "is no regular file"),
        ("to_pipe.csv", "is no regular file"),
        ("folder", "is a folder"),
        (".", "is a folder"),
        ("", "is a folder"),
        ("gone/new.csv", "the folder gone does not exist"),
        ("old.csv/new.csv", "the folder old.csv does not exist"),
        ("circle.csv", "cannot be written"),
        ("x" * 300, "cannot be written"),
    ],
)
def test_what_is_no_place_for_a_file_is_refused_and_left_alone(here, name, said):
    before = sorted(os.listdir(here))
    for write in (lambda path: write_whole(path, b"new"), target_of):
        with pytest.raises(InputError, match=said) as error:
            write(Path(name))
        assert "\n" not in str(error.value)
    assert sorted(os.listdir(here)) == before
    assert Path("pipe.png").is_fifo()


def test_a_link_stays_a_link_and_what_it_names_is_written(here):
    for link, target in (("to_old.csv", "old.csv"), ("to_new.csv", "folder/new.csv")):
        write_whole(Path(link), b"new")
        assert Path(link).is_symlink()
        assert Path(target).read_bytes() == b"new"


def test_what_breaks_off_leaves_the_old_file_and_no_draft(here):
    before = sorted(os.listdir(here))
    with full_after(10), pytest.raises(InputError, match=r"old.csv: cannot be written \(File too"):
        write_whole(Path("old.csv"), b"new" * 10)
    with contextlib.suppress(KeyboardInterrupt), replacing(Path("old.csv")) as draft:
        draft.write_text("half")
        raise KeyboardInterrupt
    assert Path("old.csv").read_text() == "old"
    assert sorted(os.listdir(here)) == before


def test_two_who_write_the_same_file_do_not_meet(here):
    with replacing(Path("a.mp4")) as one, replacing(Path("a.mp4")) as other:
        assert one != other
        assert one.suffix == other.suffix == ".mp4"


def test_a_name_as_long_as_the_system_takes_can_be_written(here):
    path = Path("x" * 251 + ".csv")
    write_whole(path, b"new")
    assert path.read_bytes() == b"new"


def test_a_finished_file_is_put_in_its_place_on_any_file_system(here, monkeypatch):
    for path in (Path("source"), Path("again")):
        path.write_bytes(b"put")
    put(Path("source"), Path("to_old.csv"))
    rename = Path.replace

    def elsewhere(self, target):
        if self.name == "again":
            raise OSError(errno.EXDEV, "Invalid cross-device link")
        return rename(self, target)

    monkeypatch.setattr(Path, "replace", elsewhere)
    put(Path("again"), Path("other.csv"))
    assert Path("old.csv").read_bytes() == Path("other.csv").read_bytes() == b"put"
    assert not Path("source").exists()
    assert not Path("again").exists()


def test_a_folder_is_made_and_tried(here):
    prepare_folder(Path("new/inner"))
    assert os.listdir("new/inner") == []
    for name in ("old.csv", "old.csv/inner", "/proc/new"):
        with pytest.raises(InputError, match="expected a folder"):
            prepare_folder(Path(name))


def test_no_command_replaces_what_is_no_regular_file(here, capfd):
    film = "is no regular file; expected one, or a new name"
    assert film in complaint(capfd, "throw --player hover --out pipe.png", here)
    assert film in complaint(capfd, f"serves from-flight {FLIGHT} --out to_pipe.csv", here)
    for place, said in ((".", "is a folder"), ("old.csv/x.csv", "the folder old.csv does not")):
        assert said in complaint(capfd, f"serves from-flight {FLIGHT} --out {place}", here)
    assert Path("pipe.png").is_fifo()
    assert Path("to_pipe.csv").is_symlink()


def test_serves_go_where_a_link_points(here, capfd):
    status, _, err = ask(capfd, "serves", "from-flight", FLIGHT, "--out", "to_old.csv", "--json")
    assert (status, err) == (0, "")
    assert Path("to_old.csv").is_symlink()
    assert Path("old.csv").read_text().startswith("x_m,")


def test_demonstrations_never_take_the_place_of_a_pipe(here):
    with pytest.raises(StoreError, match="is no regular file"):
        write_demonstrations("pipe.png", shipped_demonstrations())
    write_demonstrations("to_old.csv", shipped_demonstrations())
    assert Path("to_old.csv").is_symlink()


@pytest.mark.parametrize("name", FILES)
def test_a_demo_refuses_a_pipe_of_its_name_and_follows_a_link(here, name):
    out = here / "demo"
    out.mkdir()
    os.mkfifo(out / name)
    with pytest.raises(InputError, match="is no regular file"), finished_together(out):
        raise AssertionError
    (out / name).unlink()
    (out / name).symlink_to(here / "folder" / name)
    with finished_together(out) as draft:
        for made in FILES:
            (draft / made).write_text(made)
    assert (out / name).is_symlink()
    assert (here / "folder" / name).read_text() == name


def test_an_error_in_a_demo_names_the_folder_that_was_asked_for(here):
    for error in (StoreError, InputError):
        with pytest.raises(error) as caught, finished_together(here / "demo") as draft:
            raise error(f"{draft / 'experience.sqlite'}: the disk is full")
        assert str(caught.value) == f"{here / 'demo' / 'experience.sqlite'}: the disk is full"
    with (
        pytest.raises(InputError, match="demo: cannot be written") as caught,
        finished_together(here / "demo") as draft,
        full_after(3),
    ):
        (draft / "report.html").write_text("report")
    assert ".demo-" not in str(caught.value)


def test_a_film_that_does_not_fit_is_an_error_and_leaves_the_old_one(here, capfd):
    film = here / "serve.mp4"
    film.write_text("old")
    before = sorted(os.listdir(here))
    throw(Spec("hover"), 0, here / "fits.mp4", slow=1.0)
    (here / "fits.mp4").unlink()
    capfd.readouterr()
    with full_after(2**16), pytest.raises(InputError, match="is the disk full"):
        throw(Spec("hover"), 0, film, slow=1.0)
    assert capfd.readouterr().err == ""
    assert film.read_text() == "old"
    assert sorted(os.listdir(here)) == before


def test_a_marked_picture_that_does_not_fit_leaves_none(here, capfd):
    picture = np.random.default_rng(0).integers(0, 255, (360, 640, 3), np.uint8)
    cv2.imwrite("noise.png", picture)
    with full_after(2**16):
        status, _, err = ask(capfd, "detect", "noise.png", "--out", "marked")
    assert (status, err.count("\n")) == (2, 1)
    assert "00000-noise.png: cannot be written" in err
    assert os.listdir("marked") == []

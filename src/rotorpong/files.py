"""Files that are there whole or not at all.

What is being written carries another name, beside its place, until it is whole; then it takes the
place of what was there. Links are followed, so that a link stays a link. What is no regular file (a
device, a pipe, a folder) is never replaced.
"""

import errno
import hashlib
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from rotorpong.conventions import InputError


def target_of(path: Path) -> Path:
    """Return where a file of this name goes, links followed.

    Raises:
        InputError: there is something that is no regular file, or there is no such folder.
    """
    try:
        target = path.resolve()
        if target.is_dir():
            raise InputError(f"{path}: is a folder; expected a file")
        if target.exists() and not target.is_file():
            raise InputError(f"{path}: is no regular file; expected one, or a new name")
        if not target.parent.is_dir():
            raise InputError(f"{path}: the folder {path.parent} does not exist")
    except (OSError, RuntimeError) as error:  # RuntimeError: links in a circle, before Python 3.13
        raise _unwritable(path, error) from None
    if not os.access(target.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written, the folder {path.parent} is read-only")
    return target


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a name to write to, with the suffix of `path`; it becomes `path` if all goes well.

    Raises:
        InputError: `path` cannot be written, or what is there must not be replaced.
    """
    target = target_of(path)
    token = f"{os.getpid()}-{secrets.token_hex(4)}"
    draft = target.with_name(f".rotorpong-{token}.part{path.suffix.lower()}")
    try:
        draft.touch()
        yield draft
        _sync(draft)
        draft.replace(target)
        sync_folder(target.parent)
    except OSError as error:
        raise _unwritable(path, error) from error
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def write_whole(path: Path, data: bytes) -> None:
    """Write a file in place of what was there.

    Raises:
        InputError: see `replacing`.
    """
    with replacing(path) as draft:
        draft.write_bytes(data)


def put(source: Path, path: Path) -> None:
    """Give a finished file its place; it leaves the one it had.

    Raises:
        InputError: see `replacing`.
    """
    target = target_of(path)
    try:
        source.replace(target)
    except OSError as error:
        if error.errno != errno.EXDEV:  # a link to another file system
            raise _unwritable(path, error) from error
        write_whole(target, source.read_bytes())
        source.unlink()


def prepare_folder(path: Path) -> None:
    """Make a folder, unless it is there, and try whether it can be written.

    Raises:
        InputError: it is a file, or cannot be made or written.
    """
    try:
        if path.exists() and not path.is_dir():
            raise InputError(f"{path}: is a file; expected a folder, or the name of a new one")
        path.mkdir(parents=True, exist_ok=True)
        TemporaryDirectory(prefix=".rotorpong-", suffix=".part", dir=path).cleanup()
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"{path}: {reason}; expected a folder that can be written") from error


def digest_of(path: Path) -> str:
    """Return the SHA-256 of a file's bytes, or of those of all files right in a folder, by name.

    Raises:
        InputError: it cannot be read.
    """
    digest = hashlib.sha256()
    try:
        files = sorted(filter(Path.is_file, path.iterdir())) if path.is_dir() else [path]
        for file in files:
            data = file.read_bytes()
            digest.update(f"{file.name if path.is_dir() else ''}\0{len(data)}\0".encode())
            digest.update(data)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    return digest.hexdigest()


def sync_folder(folder: Path) -> None:
    """Make a new name in `folder` survive power loss, where the system can."""
    with suppress(OSError):
        _sync(folder)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _unwritable(path: Path, error: Exception) -> InputError:
    reason = error.strerror if isinstance(error, OSError) and error.strerror else error
    return InputError(f"{path}: cannot be written ({reason})")

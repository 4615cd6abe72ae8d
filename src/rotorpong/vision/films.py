"""Films written frame by frame, that are there whole or not at all.

MPEG-4 in .mp4, .m4v, .mov and .mkv, its XviD flavour in .avi: what the OpenCV wheel can write
everywhere. Its pictures have even sides, so an odd picture repeats its last column or row. OpenCV's
writer says nothing when it fails, so what was written is read back and counted before it takes its
place.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import cv2
from numpy import ndarray

from rotorpong.conventions import InputError, Picture
from rotorpong.files import replacing
from rotorpong.vision.pictures import hush_codecs, name_for_opencv, read_pictures

CODECS = {".mp4": "mp4v", ".m4v": "mp4v", ".mov": "mp4v", ".mkv": "mp4v", ".avi": "XVID"}
LARGEST_SIDE_PX = 8190  # of MPEG-4
DECIMALS = (3, 2, 1, 0)  # of a frame rate: the clock of MPEG-4 has 16 bits


class Film:
    """A film that is being written."""

    def __init__(self, draft: Path, path: Path, frames_per_second: float) -> None:
        """Write to `draft` what is called `path` towards the user."""
        self._draft, self._path, self._rate = draft, path, frames_per_second
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)
        self.frames = 0

    def write(self, picture: Picture) -> None:
        """Add a frame.

        Raises:
            InputError: no film of such pictures can be written, or it is not as large as the first.
        """
        height, width = picture.shape[:2]
        if self._writer is None:
            self._size = (width, height)
            self._writer = self._opened(width + width % 2, height + height % 2)
        if (width, height) != self._size:
            raise InputError(
                f"{self._path}: a frame of {width} x {height} after frames of "
                f"{self._size[0]} x {self._size[1]} pixels; expected one size"
            )
        self._writer.write(_even(picture))
        self.frames += 1

    def close(self) -> None:
        """Finish the file."""
        if self._writer is not None:
            self._writer.release()

    def _opened(self, width: int, height: int) -> cv2.VideoWriter:
        if max(width, height) > LARGEST_SIDE_PX:
            raise InputError(
                f"{self._path}: frames of {width} x {height} pixels; expected at most "
                f"{LARGEST_SIDE_PX} each way in a film"
            )
        codec = cv2.VideoWriter.fourcc(*CODECS[self._path.suffix.lower()])
        for rate in dict.fromkeys(round(self._rate, decimals) for decimals in DECIMALS):
            writer = cv2.VideoWriter(name_for_opencv(self._draft), codec, rate, (width, height))
            if writer.isOpened():
                return writer
            writer.release()
        raise InputError(f"{self._path}: this OpenCV cannot write MPEG-4 there")


@contextmanager
def film(path: Path, frames_per_second: float) -> Iterator[Film]:
    """Give a film to write frames to; it becomes `path` if all goes well.

    Raises:
        InputError: an unknown suffix, a place that cannot be written, or the film broke off.
    """
    if path.suffix.lower() not in CODECS:
        raise InputError(f"{path}: expected a name that ends with {', '.join(CODECS)}")
    hush_codecs()
    with replacing(path) as draft:
        made = Film(draft, path, frames_per_second)
        try:
            yield made
        finally:
            made.close()
        if _frames_in(draft) != made.frames:
            raise InputError(f"{path.parent}: a film broke off there; is the disk full?")


def _even(picture: Picture) -> ndarray:
    height, width = picture.shape[:2]
    if not (height % 2 or width % 2):
        return picture
    return cv2.copyMakeBorder(picture, 0, height % 2, 0, width % 2, cv2.BORDER_REPLICATE)


def _frames_in(path: Path) -> int:
    try:
        return sum(1 for _ in read_pictures([path]))
    except InputError:  # damaged
        return 0

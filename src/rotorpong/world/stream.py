"""Frames as the drone's video stream brings them: through an H.264 encoder and decoder.

Baseline profile, one slice, no delay (zerolatency), as the AR.Drone 2.0 sends; about 1 Mbit/s at
640 x 360. A frame depends on all before it, so they are made and coded in order, but not before
somebody looks at one. One thread: the same frames give the same pictures.
"""

import importlib
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from rotorpong.conventions import InputError, Picture
from rotorpong.physics.camera import Camera

FRAMES_PER_KEY_FRAME = 30
CODEC = {"preset": "ultrafast", "tune": "zerolatency", "profile": "baseline", "threads": "1"}


class Stream:
    """One serve's video, from camera to player."""

    def __init__(self, camera: Camera) -> None:
        """Open encoder and decoder.

        Raises:
            InputError: the package PyAV is not installed, or H.264 has no pictures of this size.
        """
        av = _av()
        if camera.width_px % 2 or camera.height_px % 2:
            raise InputError(
                f"camera {camera.name!r}: H.264 carries pictures of even width and height only, "
                f"not {camera.width_px} x {camera.height_px}; set stream_mbit_s to 0"
            )
        self._as_frame = av.VideoFrame.from_ndarray
        self._encoder = av.CodecContext.create("libx264", "w")
        self._encoder.width, self._encoder.height = camera.width_px, camera.height_px
        self._encoder.pix_fmt = "yuv420p"
        self._encoder.bit_rate = round(camera.stream_mbit_s * 1e6)
        self._encoder.gop_size = FRAMES_PER_KEY_FRAME
        rate = Fraction(camera.frames_per_second).limit_denominator(1000)
        self._encoder.framerate, self._encoder.time_base = rate, 1 / rate
        self._encoder.options = CODEC
        self._decoder = av.CodecContext.create("h264", "r")
        self._decoder.thread_count = 1
        self._waiting: list[tuple[Callable[[], Picture], dict[str, Picture]]] = []
        self._count = 0

    def send(self, source: Callable[[], Picture]) -> Callable[[], Picture]:
        """Queue a frame; return what makes its picture, and all those before it, when called."""
        arrived: dict[str, Picture] = {}
        self._waiting.append((source, arrived))

        def picture() -> Picture:
            while "picture" not in arrived:
                self._code(*self._waiting.pop(0))
            return arrived["picture"]

        return picture

    def _code(self, source: Callable[[], Picture], arrived: dict[str, Picture]) -> None:
        frame = self._as_frame(source(), format="bgr24").reformat(format="yuv420p")
        frame.pts = self._count
        self._count += 1
        for packet in self._encoder.encode(frame):
            for decoded in self._decoder.decode(packet):
                arrived["picture"] = decoded.to_ndarray(format="bgr24")


def _av() -> Any:
    try:
        return importlib.import_module("av")
    except ImportError:
        raise InputError(
            "a camera with stream_mbit_s above 0 needs PyAV, which is not installed: "
            "pip install 'rotorpong[drone]', or set stream_mbit_s to 0"
        ) from None

"""Pictures as plain JSON: what jobs return of frames, and how figures get them back."""

import base64

import cv2
import numpy as np

from rotorpong.conventions import InputError, Picture


def as_text(picture: Picture) -> str:
    """Return a picture as PNG in base64."""
    _, png = cv2.imencode(".png", picture)
    return base64.b64encode(png.tobytes()).decode("ascii")


def as_rgb(text: str) -> Picture:
    """Return what `as_text` made of a picture, red first, as matplotlib shows it.

    Raises:
        InputError: it is no picture.
    """
    png = np.frombuffer(base64.b64decode(text), np.uint8)
    decoded = cv2.imdecode(png, cv2.IMREAD_COLOR) if len(png) else None
    if decoded is None:
        raise InputError(f"{text[:20]!r}: expected a PNG in base64")
    return np.ascontiguousarray(decoded[..., ::-1])

"""A frame shows its parts as it shows itself."""

import numpy as np
import pytest

from rotorpong.conventions import InputError
from rotorpong.drone import Frame

PICTURE = np.random.default_rng(0).integers(0, 256, (6, 8, 3), dtype=np.uint8)


def test_a_region_is_a_crop_whoever_makes_it():
    boxes = []

    def box_source(box):
        boxes.append(box)
        x0, y0, x1, y1 = box
        return PICTURE[y0:y1, x0:x1].copy()

    for frame in (Frame(8, 6, lambda: PICTURE), Frame(8, 6, lambda: PICTURE, box_source)):
        np.testing.assert_array_equal(frame.region(2, 1, 7, 6), PICTURE[1:6, 2:7])
    assert boxes == [(2, 1, 7, 6)]


def test_a_picture_that_is_there_is_not_made_again_for_a_part_of_it():
    frame = Frame(8, 6, lambda: PICTURE, lambda box: pytest.fail("made again"))
    assert frame.picture is PICTURE
    np.testing.assert_array_equal(frame.region(0, 0, 8, 6), PICTURE)


@pytest.mark.parametrize("box", [(2, 1, 2, 6), (-1, 0, 3, 3), (0, 0, 9, 6), (0, 5, 8, 7)])
def test_a_region_that_is_none_is_refused(box):
    with pytest.raises(InputError, match="8 x 6"):
        Frame(8, 6, lambda: PICTURE).region(*box)

"""
Pictures to calibrate with
==========================

What ``rotorpong calibrate`` learns from: chessboards, and green balls in boxes::

    python examples/draw_calibration.py calibration
    rotorpong calibrate camera calibration/boards --out camera.json
    rotorpong calibrate colour calibration/balls/boxes.csv --out green.json

The folder gets ``boards``, twelve pictures of a board by a camera with a focal length of 374.7 px,
and ``balls`` with ``boxes.csv``, frames of the simulated court with a green ball in each. With
pictures of your own in their place, the same commands calibrate your camera and your ball. Without
a folder nothing is kept.
"""

import sys
import tempfile
from pathlib import Path

import cv2
import matplotlib.pyplot as plt
import numpy as np

from rotorpong.conventions import CAMERA_FROM_BODY_AXES
from rotorpong.physics.camera import GAZEBO
from rotorpong.world.racket import HOME_BODY
from rotorpong.world.render import Scene, ball_coverage, render

SQUARE_PX = 50  # of the board, 10 x 7 squares, before it is seen
GREEN = (70, 190, 80)  # blue, green, red
BALLS = 6
NOISE = 2.0  # levels, standard deviation


def draw_boards(folder: Path, rng: np.random.Generator) -> None:
    """Tilt a board twelve ways, and move it all over the picture."""
    folder.mkdir(parents=True, exist_ok=True)
    size = np.array([12, 9]) * SQUARE_PX  # with a white margin
    board = np.full(size[::-1], 240, np.uint8)
    squares = np.indices((7, 10)).sum(axis=0) % 2 * 215 + 20
    board[SQUARE_PX:-SQUARE_PX, SQUARE_PX:-SQUARE_PX] = np.kron(
        squares, np.ones((SQUARE_PX, SQUARE_PX), int)
    )
    for i in range(12):
        turn = cv2.Rodrigues(rng.uniform(-0.6, 0.6, 3))[0]
        x, y = 0.13 * (i % 4 - 1.5), 0.1 * (i // 4 - 1)
        place = np.array([x, y, rng.uniform(0.4, 0.5)])
        metres = 0.025 / SQUARE_PX * np.array([[1, 0, -size[0] / 2], [0, 1, -size[1] / 2]])
        flat = np.vstack([metres, [0, 0, 1]])
        (fx, fy), (cx, cy) = GAZEBO.focal_length_px, GAZEBO.center_px
        lens = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
        seen = lens @ np.column_stack([turn[:, 0], turn[:, 1], place]) @ flat
        large = np.diag([4.0, 4.0, 1.0]) @ seen
        shape = (4 * GAZEBO.width_px, 4 * GAZEBO.height_px)
        picture = cv2.warpPerspective(board, large, shape, borderValue=(110,))
        small = cv2.resize(picture, (640, 360), interpolation=cv2.INTER_AREA)
        write(folder / f"board{i:02d}.png", small, rng)


def draw_balls(folder: Path, rng: np.random.Generator) -> None:
    """Put a green ball before the hovering drone, and say where."""
    folder.mkdir(parents=True, exist_ok=True)
    eye = np.array(HOME_BODY) + GAZEBO.position_m
    pose = (GAZEBO, eye, CAMERA_FROM_BODY_AXES.T)
    rows = ["picture,x0,y0,x1,y1"]
    for i in range(BALLS):
        ball = eye + rng.uniform((0.5, -0.3, -0.15), (1.5, 0.3, 0.15))
        write(folder / f"ball{i}.png", render(*pose, ball, Scene(ball=GREEN)), rng)
        covered = np.argwhere(ball_coverage(*pose, ball) > 0.5)
        (y0, x0), (y1, x1) = covered.min(axis=0), covered.max(axis=0) + 1
        rows.append(f"ball{i}.png,{x0},{y0},{x1},{y1}")
    (folder / "boxes.csv").write_text("\n".join(rows) + "\n")


def write(path: Path, picture: np.ndarray, rng: np.random.Generator) -> None:
    """Write a picture with noise."""
    noisy = np.round(picture + rng.normal(0.0, NOISE, picture.shape))
    cv2.imwrite(str(path), np.clip(noisy, 0, 255).astype(np.uint8))


# %%
# A board, and a ball in its box.


def main() -> None:
    """Draw both folders, and show a picture of each."""
    rng = np.random.default_rng(0)
    with tempfile.TemporaryDirectory() as passing:
        folder = Path(sys.argv[1] if len(sys.argv) > 1 else passing)
        draw_boards(folder / "boards", rng)
        draw_balls(folder / "balls", rng)
        show(folder)
    print("12 boards and", BALLS, "balls", f"in {folder}" if len(sys.argv) > 1 else "drawn")


def show(folder: Path) -> None:
    """Show the first board, and the first ball with its box."""
    plt.switch_backend("agg")  # a figure needs no display
    _, (left, right) = plt.subplots(1, 2, figsize=(9.0, 2.7), layout="constrained")
    left.imshow(cv2.imread(str(folder / "boards" / "board00.png"))[..., ::-1])
    right.imshow(cv2.imread(str(folder / "balls" / "ball0.png"))[..., ::-1])
    box = (folder / "balls" / "boxes.csv").read_text().splitlines()[1].split(",")[1:]
    x0, y0, x1, y1 = map(int, box)
    right.add_patch(plt.Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, color="red"))
    left.set_title("boards/board00.png")
    right.set_title("balls/ball0.png, " + f"box {','.join(box)}")
    for axes in (left, right):
        axes.set_axis_off()


if __name__ == "__main__":
    main()

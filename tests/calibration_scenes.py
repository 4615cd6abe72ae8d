"""Chessboards and coloured balls of known cameras and places, drawn by OpenCV alone."""

import cv2
import numpy as np

from rotorpong.physics.camera import ARDRONE2_360P

SQUARE_TEXELS = 32
SAMPLES = 2  # per pixel and axis
ROTATIONS = [  # of the board, rad: tilted by about 30 degrees, each another way
    (0.5, 0.0, 0.0), (-0.5, 0.1, 0.0), (0.0, 0.5, 0.1), (0.1, -0.5, 0.0),
    (0.4, 0.4, 0.0), (-0.4, 0.4, 0.2), (0.4, -0.4, 0.0), (-0.4, -0.4, -0.2), (0.1, 0.0, 0.3),
    (0.5, 0.2, -0.3),
]  # fmt: skip
PLACES = [  # of its middle, m
    (0.0, 0.0, 0.36), (-0.06, 0.03, 0.4), (0.06, -0.03, 0.4), (0.05, 0.03, 0.44),
    (-0.1, -0.03, 0.48), (0.1, 0.04, 0.48), (-0.1, 0.05, 0.48), (0.1, -0.05, 0.48),
    (0.0, 0.0, 0.4), (-0.05, 0.0, 0.4),
]  # fmt: skip


def matrix_of(camera):
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def corners_of(camera, rotation, place, columns=9, rows=6, square=0.025):
    """Where `cv2.projectPoints` puts the inner corners of a board, px."""
    grid = np.mgrid[:rows, :columns].reshape(2, -1)[::-1].T.astype(float)
    points = (grid - ((columns - 1) / 2, (rows - 1) / 2)) * square
    points = np.column_stack([points, np.zeros(len(points))])
    lens = np.array(camera.distortion)
    vectors = np.array(rotation, float), np.array(place, float)
    return cv2.projectPoints(points, *vectors, matrix_of(camera), lens)[0].reshape(-1, 2)


def board_picture(camera, rotation, place, columns=9, rows=6, square=0.025):
    """A board as the camera sees it: every pixel looks up its own ray on the board's plane."""
    size = ((columns + 1) * SQUARE_TEXELS, (rows + 1) * SQUARE_TEXELS)
    across, down = np.arange(size[0]) // SQUARE_TEXELS, np.arange(size[1]) // SQUARE_TEXELS
    texture = np.where((across + down[:, None]) % 2, 235, 20).astype(np.uint8)
    texture = cv2.copyMakeBorder(texture, *[SQUARE_TEXELS] * 4, cv2.BORDER_CONSTANT, value=235)
    shape = camera.height_px * SAMPLES, camera.width_px * SAMPLES
    y, x = (np.indices(shape) + 0.5) / SAMPLES - 0.5
    pixels = np.stack([x, y], -1).reshape(-1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-10)
    lens = np.array(camera.distortion)
    rays = cv2.undistortPoints(pixels, matrix_of(camera), lens, criteria=stop).reshape(-1, 2)
    turn = cv2.Rodrigues(np.array(rotation, float))[0]
    plane = np.linalg.inv(np.column_stack([turn[:, 0], turn[:, 1], place]))
    seen = np.column_stack([rays, np.ones(len(rays))]) @ plane.T
    board = seen[:, :2] / seen[:, 2:] / square * SQUARE_TEXELS
    board += np.array(size) / 2 + SQUARE_TEXELS - 0.5
    maps = board.reshape(*shape, 2).astype(np.float32)
    drawn = cv2.remap(texture, maps, None, cv2.INTER_LINEAR, borderValue=120)
    small = cv2.resize(drawn, (camera.width_px, camera.height_px), interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_GRAY2BGR)


def write_boards(folder, count=10, camera=ARDRONE2_360P, rotations=ROTATIONS):
    """Write pictures of a board at `count` places into a new folder."""
    folder.mkdir()
    rng = np.random.default_rng(0)
    for i in range(count):
        clean = board_picture(camera, rotations[i], PLACES[i])
        noisy = clean + rng.normal(0.0, 2.0, clean.shape[:2])[..., None]
        cv2.imwrite(str(folder / f"{i:02d}.png"), np.clip(noisy, 0, 255).astype(np.uint8))
    return folder


def ball_scene(rng, colour, background=(110, 100, 90), balls=3, shape=(240, 320)):
    """Shaded balls on noise, and their boxes (x0, y0, x1, y1)."""
    picture = np.full((*shape, 3), background, float)
    boxes = []
    for i in range(balls):
        radius = rng.uniform(6.0, 16.0)
        x, y = (i + 0.5) * shape[1] / balls + rng.uniform(-10, 10), rng.uniform(40, shape[0] - 40)
        down, across = np.indices(shape)
        u, v = (across - x) / radius, (down - y) / radius
        inside = np.clip((1.0 - np.hypot(u, v)) * radius + 0.5, 0.0, 1.0)[..., None]
        shade = 0.85 - 0.25 * np.clip(v, -1, 1)  # lit from above
        picture = (1 - inside) * picture + inside * shade[..., None] * np.array(colour)
        box = (np.floor(x - radius), np.floor(y - radius), np.ceil(x + radius), np.ceil(y + radius))
        boxes.append(tuple(int(side) for side in (*box[:2], box[2] + 1, box[3] + 1)))
    return np.clip(picture + rng.normal(0, 3, picture.shape), 0, 255).astype(np.uint8), boxes


def write_balls(folder, colour, pictures=3, **scene):
    """Write pictures of balls and a CSV of their boxes into a new folder; return the CSV."""
    folder.mkdir()
    rng, rows = np.random.default_rng(1), ["picture,x0,y0,x1,y1"]
    for i in range(pictures):
        picture, boxes = ball_scene(rng, colour, **scene)
        cv2.imwrite(str(folder / f"{i}.png"), picture)
        rows += [",".join(map(str, (f"{i}.png", *box))) for box in boxes]
    (folder / "boxes.csv").write_text("\n".join(rows) + "\n")
    return folder / "boxes.csv"

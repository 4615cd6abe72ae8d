"""The onboard picture shows what geometry says, to a fraction of a pixel."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from rotorpong.conventions import BALL_RADIUS, InputError
from rotorpong.geometry import quaternion_from_euler, rotation_from_quaternion
from rotorpong.physics.camera import ARDRONE2_720P, GAZEBO, Camera, camera_from_body
from rotorpong.world import court
from rotorpong.world._survey_kernels import A_HIGH, A_LOW, B_HIGH, B_LOW, LANES, Lens
from rotorpong.world.render import (
    IDEAL,
    Scene,
    ball_coverage,
    lens_at_door,
    paint_of,
    render,
    still,
    take,
)

CAMERAS = pytest.mark.parametrize("camera", [GAZEBO, ARDRONE2_720P], ids=lambda c: c.name)
BARE = Scene(opponent=False, texture_contrast=0.0, ball_shadow=0.0)
GREEN = (0.0, 200.0, 0.0)
NOWHERE = np.array([-4.0, 0.0, 2.0])  # behind the camera
TINY = Camera("tiny", 96, 54, (56.2, 56.2), (47.5, 26.5))


def pose(camera, body=(-1.90, 0.0, 0.19), angles=(0.0, 0.0, 0.0)):
    rotation = rotation_from_quaternion(quaternion_from_euler(np.array(angles, dtype=float)))
    position = np.array(body) + rotation @ np.array(camera.position_m)
    return position, np.ascontiguousarray(rotation @ camera_from_body(camera).T)


def opencv_pixels(camera, points):
    (fx, fy), (cx, cy) = camera.focal_length_px, camera.center_px
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    pixels, _ = cv2.projectPoints(
        np.ascontiguousarray(points), np.zeros(3), np.zeros(3), matrix, np.array(camera.distortion)
    )
    return pixels[:, 0]


def outline(camera, center, count=720):
    """Where OpenCV sees the circle along which lines of sight touch the sphere."""
    squared = center @ center
    along = center / np.sqrt(squared)
    side = np.cross(along, [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    up = np.cross(along, side)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    shrink = 1 - BALL_RADIUS**2 / squared
    ring = BALL_RADIUS * np.sqrt(shrink) * (np.cos(angle) * side + np.sin(angle) * up)
    return opencv_pixels(camera, center * shrink + ring)


def area_and_centroid(polygon):
    x, y = polygon.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    total = (polygon + np.roll(polygon, -1, axis=0)) * cross[:, None]
    return abs(area), total.sum(axis=0) / (6 * area)


def random_balls(camera, rng, count):
    """Balls of 8 to 60 pixels, wholly in the picture, in the camera frame."""
    focal = camera.focal_length_px[0]
    while count > 0:
        depth = focal * 2 * BALL_RADIUS / rng.uniform(8.0, 60.0)
        half = np.array([camera.width_px, camera.height_px]) / (2 * focal)
        center = np.array([*(rng.uniform(-1, 1, 2) * half * 0.9), 1.0]) * depth
        pixels = outline(camera, center)
        if np.all(pixels > 2) and np.all(pixels < [camera.width_px - 3, camera.height_px - 3]):
            count -= 1
            yield center, pixels


@pytest.mark.parametrize("instants", [1, 8])
@CAMERAS
def test_the_ball_covers_the_ellipse_that_opencv_projects(camera, instants):
    position, rotation = pose(camera, angles=(0.1, -0.2, 0.3))
    errors, offsets = [], []
    rows, columns = np.mgrid[: camera.height_px, : camera.width_px]
    for center, pixels in random_balls(camera, np.random.default_rng(0), 80):
        ball = position + rotation @ center
        coverage = ball_coverage(camera, position, rotation, ball, instants=instants)
        coverage = coverage.astype(float)
        area, centroid = area_and_centroid(pixels)
        errors.append(np.sqrt(4 * coverage.sum() / np.pi) - np.sqrt(4 * area / np.pi))
        mean = np.array([(columns * coverage).sum(), (rows * coverage).sum()]) / coverage.sum()
        offsets.append(np.linalg.norm(mean - centroid))
    assert np.std(errors) <= 0.02
    assert abs(np.mean(errors)) <= 0.005
    assert np.max(offsets) < 0.02


def test_the_ball_in_the_picture_is_where_its_coverage_says():
    position, rotation = pose(GAZEBO)
    ball = np.array([-0.9, 0.2, 0.3])
    scene = replace(
        BARE, ball=(0.0, 0.0, 250.0), wall=(200.0, 200.0, 0.0), window=(0.0, 200.0, 0.0)
    )
    with_ball = render(GAZEBO, position, rotation, ball, scene).astype(float)
    without = render(GAZEBO, position, rotation, NOWHERE, scene).astype(float)
    coverage = ball_coverage(GAZEBO, position, rotation, ball)
    assert np.all((with_ball != without).any(axis=2) <= (coverage > 0))
    share = (without[..., 1] - with_ball[..., 1])[coverage > 0] / without[..., 1][coverage > 0]
    np.testing.assert_allclose(share, coverage[coverage > 0], atol=0.01)


@CAMERAS
@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.12, 0.05, -0.1)])
def test_lines_and_tape_are_where_opencv_projects_them(camera, angles):
    position, rotation = pose(camera, body=(-2.1, 0.1, 0.35), angles=angles)
    picture = render(camera, position, rotation, NOWHERE, BARE).astype(int)
    x = np.linspace(-1.0, -0.4, 7)
    edge = court.TABLE_HALF_WIDTH - court.EDGE_LINE_WIDTH / 2
    spots = {
        "line": [(u, side * edge, 0.0) for u in x for side in (-1, 1)],
        "table": [(u, side * (edge - 0.06), 0.0) for u in x for side in (-1, 1)],
        "tape": [(0.0, v, court.NET_HEIGHT - 0.0075) for v in np.linspace(-0.8, 0.8, 9)],
    }
    for name, points in spots.items():
        pixels = opencv_pixels(camera, (np.array(points) - position) @ rotation)
        inside = np.all((pixels > 1) & (pixels < [camera.width_px - 2, camera.height_px - 2]), 1)
        assert inside.sum() >= 5
        blue, green, red = np.median(picture[tuple(np.rint(pixels[inside]).astype(int).T[::-1])], 0)
        assert (red > 2 * blue / 3) == (name != "table"), (name, blue, green, red)


@CAMERAS
def test_the_side_of_the_table_is_where_opencv_projects_it_within_a_tenth_of_a_pixel(camera):
    position, rotation = pose(camera, body=(-2.6, 0.0, 0.9), angles=(0.03, 0.3, 0.05))
    white, black = (255.0, 255.0, 255.0), (0.0, 0.0, 0.0)
    scene = replace(BARE, table=white, line=white, wall=white, floor=black, seam=black)
    picture = render(camera, position, rotation, NOWHERE, scene)[..., 1] / 255.0
    x = np.linspace(-1.2, -0.3, 4000)
    side = np.stack([x, np.full_like(x, court.TABLE_HALF_WIDTH), np.zeros_like(x)], axis=1)
    columns, rows = opencv_pixels(camera, (side - position) @ rotation).T
    errors = []
    for row in range(int(rows.min()) + 1, int(rows.max())):
        expected = np.interp(row, rows[::-1], columns[::-1])
        if 8 < expected < camera.width_px - 8:
            first, last = int(expected) - 6, int(expected) + 7
            errors.append(last - 0.5 - picture[row, first:last].sum() - expected)
    assert len(errors) > 40
    assert abs(np.mean(errors)) < 0.02
    assert np.max(np.abs(errors)) < 0.1


@CAMERAS
def test_a_region_has_the_pixels_of_the_whole_picture(camera):
    rng = np.random.default_rng(1)
    position, rotation = pose(camera, angles=(0.1, -0.05, 0.2))
    ball = position + rotation @ np.array([0.1, 0.02, 0.9])
    whole = render(camera, position, rotation, ball, Scene())
    for _ in range(15):
        x0, x1 = np.sort(rng.choice(camera.width_px + 1, 2, replace=False)).tolist()
        y0, y1 = np.sort(rng.choice(camera.height_px + 1, 2, replace=False)).tolist()
        box = render(camera, position, rotation, ball, Scene(), region=(x0, y0, x1, y1))
        np.testing.assert_array_equal(box, whole[y0:y1, x0:x1])
    one = render(camera, position, rotation, ball, Scene(), region=(7, 9, 8, 10))
    np.testing.assert_array_equal(one, whole[9:10, 7:8])


@CAMERAS
def test_a_picture_is_the_same_when_everything_is_looked_for_everywhere(camera):
    """Bounds on the rays of each piece spare work; with none, no work is spared."""
    rng = np.random.default_rng(11)
    lens = lens_at_door(camera)
    bounds = lens.bounds.copy()
    for least, most in ((A_LOW, A_HIGH), (B_LOW, B_HIGH)):
        bounds[..., least : least + LANES], bounds[..., most : most + LANES] = -1e6, 1e6
    for spread in (0.05, 0.4, 3.0, 3.0, 3.0):
        body = rng.uniform((-4.0, -3.0, -0.6), (4.0, 3.0, 2.5)) if spread > 1 else (-1.9, 0.1, 0.2)
        position, rotation = pose(camera, body, rng.normal(0.0, spread, 3))
        shutter = still(position, rotation, position + rotation @ np.array([0.02, -0.03, 0.4]))
        whole = (0, 0, camera.width_px, camera.height_px)
        sparing, thorough = (
            take(this, whole, (shutter, 1), paint_of(Scene()), IDEAL)
            for this in (lens, Lens(lens.rays, bounds))
        )
        np.testing.assert_array_equal(sparing, thorough)


@pytest.mark.parametrize("ball", [(-2.5, 0.0, 0.2), (2.0, 3.9, 0.2), (0.0, 0.0, 3.0)])
def test_a_ball_out_of_view_changes_nothing(ball):
    position, rotation = pose(ARDRONE2_720P)
    seen = render(ARDRONE2_720P, position, rotation, np.array(ball), Scene())
    unseen = render(ARDRONE2_720P, position, rotation, NOWHERE, Scene())
    np.testing.assert_array_equal(seen, unseen)
    assert ball_coverage(ARDRONE2_720P, position, rotation, np.array(ball)).sum() == 0


def reds(camera, ball, point, body):
    """Red minus blue at a world point, with and without the ball."""
    position, rotation = pose(camera, body=body)
    x, y = np.rint(opencv_pixels(camera, (np.array([point]) - position) @ rotation)[0]).astype(int)
    box = (int(x), int(y), int(x) + 1, int(y) + 1)
    pictures = [
        render(camera, position, rotation, np.array(b), BARE, region=box)[0, 0].astype(int)
        for b in (ball, NOWHERE)
    ]
    return [p[2] - p[0] for p in pictures]


def test_the_tape_hides_the_ball_and_the_mesh_lets_it_through():
    body = (-1.90, 0.0, 0.19)
    position, _ = pose(GAZEBO, body)
    for height, visible in ((court.NET_HEIGHT - 0.0075, False), (0.09, True)):
        point = np.array([0.0, 0.0, height])
        behind, nothing = reds(GAZEBO, position + 1.1 * (point - position), point, body)
        before, _ = reds(GAZEBO, position + 0.9 * (point - position), point, body)
        assert (behind - nothing > 30) == visible
        assert before > behind + 5


def test_the_table_hides_what_is_under_it():
    position, rotation = pose(GAZEBO)
    below = render(GAZEBO, position, rotation, np.array([-0.5, 0.0, -0.1]), BARE)
    np.testing.assert_array_equal(below, render(GAZEBO, position, rotation, NOWHERE, BARE))


def test_a_picture_is_the_average_of_a_finer_one():
    fine = 16
    finer = replace(
        TINY,
        width_px=TINY.width_px * fine,
        height_px=TINY.height_px * fine,
        focal_length_px=(56.2 * fine, 56.2 * fine),
        center_px=((47.5 + 0.5) * fine - 0.5, (26.5 + 0.5) * fine - 0.5),
    )
    position, rotation = pose(TINY, angles=(0.05, 0.02, 0.1))
    ball = np.array([-0.9, 0.1, 0.3])
    plain = Scene(texture_contrast=0.0)  # the texture fades where pixels outgrow it
    coarse = render(TINY, position, rotation, ball, plain).astype(float)
    average = render(finer, position, rotation, ball, plain).astype(float)
    average = average.reshape(TINY.height_px, fine, TINY.width_px, fine, 3).mean(axis=(1, 3))
    error = np.abs(coarse - average)
    assert error.mean() < 1.2
    assert np.quantile(error, 0.95) < 6.0


def twin(camera, position, rotation, scene, fine=8):
    """The court without ball and opponent, one ray per sample, plain numpy."""
    step = (np.arange(fine) + 0.5) / fine - 0.5
    u = (np.arange(camera.width_px)[:, None] + step).ravel()
    v = (np.arange(camera.height_px)[:, None] + step).ravel()
    a, b = np.meshgrid(
        (u - camera.center_px[0]) / camera.focal_length_px[0],
        (v - camera.center_px[1]) / camera.focal_length_px[1],
    )
    rays = np.stack([a, b, np.ones_like(a)], axis=-1) @ rotation.T
    picture = twin_room(position, rays, scene)
    x, y, z = np.moveaxis(position - rays * (position[2] / rays[..., 2:]), -1, 0)
    on = (rays[..., 2] < 0) & (np.abs(x) < 1.37) & (np.abs(y) < 0.7625)
    line = (np.abs(x) > 1.35) | (np.abs(y) > 0.7425) | (np.abs(y) < 0.0015)
    top = np.where(line[..., None], scene.line, scene.table)
    sheen = 0.22 * (1 - np.abs(rays[..., 2:])) ** 6
    picture = np.where(on[..., None], top + sheen * (np.array(scene.wall) - top), picture)
    depth = -position[0] / rays[..., 0]
    y, z = np.moveaxis(position + rays * depth[..., None], -1, 0)[1:]
    tall = (depth > 0) & (z < 0.1525)
    net = tall & (z > 0) & (np.abs(y) < 0.915)
    cord = (np.mod(y, 0.01) < 0.0012) | (np.mod(z, 0.01) < 0.0012)
    picture = np.where((net & (z < 0.1375) & cord)[..., None], scene.net, picture)
    picture = np.where((net & (z > 0.1375))[..., None], scene.line, picture)
    post = tall & (z > -0.022) & (np.abs(y) > 0.915) & (np.abs(y) < 0.937)
    picture = np.where(post[..., None], scene.steel, picture)
    return picture.reshape(camera.height_px, fine, camera.width_px, fine, 3).mean(axis=(1, 3))


def twin_room(position, rays, scene):
    with np.errstate(divide="ignore"):
        ends = np.where(rays > 0, [7.0, 4.0, 3.3], [-5.0, -4.0, -0.76])
        depths = (ends - position) / rays
    face = np.argmin(depths, axis=-1)
    x, y, z = np.moveaxis(position + rays * depths.min(axis=-1)[..., None], -1, 0)
    sides = ((1.37, x), (0.7625, y))
    ramps = [np.clip(1.43 * (half + 0.35 - np.abs(w)), 0, 1) for half, w in sides]
    floor = np.array(scene.floor) * (1 - 0.5 * ramps[0] * ramps[1])[..., None]
    light = np.where(face == 1, 0.93, 1.0) * np.minimum(0.78 + 0.176 * (z + 0.76), 1.0)
    colour = np.where((z > 0.445)[..., None], scene.wall, scene.wainscot)
    rail = (z > 0.42) & (z < 0.47)
    wall = np.where(rail[..., None], scene.line, colour) * light[..., None]
    level = np.where((z > 0)[..., None], scene.ceiling, floor)
    return np.where((face == 2)[..., None], level, wall)


def test_the_court_is_that_of_a_plain_numpy_twin_that_only_takes_samples():
    scene = replace(BARE, window=BARE.wall, lamp=BARE.ceiling, seam=BARE.floor)
    position, rotation = pose(TINY, body=(-1.75, 0.1, 0.25), angles=(0.1, 0.1, 0.2))
    ours = render(TINY, position, rotation, NOWHERE, scene).astype(float)
    reference = twin(TINY, position, rotation, scene)
    error = np.abs(ours - reference)  # levels of 255
    assert error.mean() < 1.0
    assert np.quantile(error, 0.98) < 9.0


def test_the_same_scene_gives_the_same_picture_and_another_seed_another():
    position, rotation = pose(GAZEBO)
    ball = np.array([0.8, 0.1, 0.35])
    first = render(GAZEBO, position, rotation, ball, Scene())
    np.testing.assert_array_equal(first, render(GAZEBO, position, rotation, ball, Scene()))
    other = render(GAZEBO, position, rotation, ball, Scene(texture_seed=1))
    assert (first != other).mean() > 0.1


def test_without_light_everything_is_black():
    position, rotation = pose(GAZEBO)
    assert not render(
        GAZEBO, position, rotation, np.array([0.8, 0, 0.3]), Scene(brightness=0)
    ).any()


def test_any_pose_in_the_room_gives_a_picture():
    rng = np.random.default_rng(2)
    for _ in range(40):
        body = rng.uniform([-4.9, -3.9, -0.7], [6.9, 3.9, 3.0])
        position, rotation = pose(TINY, body, rng.uniform(-np.pi, np.pi, 3))
        picture = render(TINY, position, rotation, rng.uniform(-2, 2, 3), Scene())
        assert picture.std() > 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ball": np.array([0.0, np.nan, 0.0])}, "ball position"),
        ({"position": np.array([np.inf, 0.0, 0.0])}, "camera position"),
        ({"rotation": 2 * np.eye(3)}, "no rotation"),
        ({"rotation": np.diag([1.0, 1.0, -1.0])}, "no rotation"),
        ({"region": (10, 10, 10, 20)}, "x0 < x1"),
        ({"region": (0, 0, 641, 20)}, "640 x 360"),
        ({"camera": replace(GAZEBO, width_px=0)}, "0 x 360"),
    ],
)
def test_what_cannot_be_rendered_is_refused(change, message):
    position, rotation = pose(GAZEBO)
    given = {"camera": GAZEBO, "position": position, "rotation": rotation, "ball": NOWHERE}
    given |= {"region": None} | change
    with pytest.raises(InputError, match=message):
        render(
            given["camera"],
            given["position"],
            given["rotation"],
            given["ball"],
            BARE,
            region=given["region"],
        )

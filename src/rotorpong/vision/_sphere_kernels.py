"""The outline of a sphere through a lens, compiled; the equations are in `sphere`."""

import math

import numpy as np

from rotorpong.kernels import kernel

OUTLINE_POINTS = 16  # periodic quadrature: exact for the lens' polynomial up to this order
FIXED_POINT_STEPS = 12
NEWTON_STEPS = 4
SMALLEST_ERROR, LARGEST_ERROR = 1e-8, 1e-5  # px
UNDISTORTION_STEPS, SMALLEST_STEP = 20, 1e-13
DIFFERENCE = 1e-4  # of the distance
SMALLEST_DEPTH = 1e-3  # cos^2 of an angle from the axis
FOUND, NO_DISC, NO_SPHERE = 0, 1, 2
_ANGLES = 2.0 * np.pi * np.arange(OUTLINE_POINTS) / OUTLINE_POINTS
COSINES, SINES = np.cos(_ANGLES), np.sin(_ANGLES)


@kernel
def discs(lens, positions, radius, out):
    """Write (x, y, radius) in pixels of spheres of `radius` at `positions`; nan if there is none.

    `lens` holds fx, fy, cx, cy, k1, k2, p1, p2, k3.
    """
    for i in range(positions.shape[0]):
        out[i, 0], out[i, 1], out[i, 2] = disc(
            lens, positions[i, 0], positions[i, 1], positions[i, 2], radius
        )


@kernel
def disc(lens, x, y, z, radius):
    """Return centroid and area radius of a sphere's picture, px."""
    squared = x * x + y * y + z * z
    if not (squared > radius * radius and z > 0.0):
        return np.nan, np.nan, np.nan
    sin2 = radius * radius / squared
    distance = math.sqrt(squared)
    nx, ny, nz = x / distance, y / distance, z / distance
    depth = nz * nz - sin2
    if depth < SMALLEST_DEPTH:
        return np.nan, np.nan, np.nan
    off_axis = math.hypot(nx, ny)
    cosine, sine = (nx / off_axis, ny / off_axis) if off_axis > 0.0 else (1.0, 0.0)
    along, across = math.sqrt(sin2 * (1.0 - sin2)) / depth, math.sqrt(sin2 / depth)
    middle_x, middle_y = nx * nz / depth, ny * nz / depth
    area, moment_x, moment_y = 0.0, 0.0, 0.0
    shift_x, shift_y = distorted(lens, middle_x, middle_y)
    for k in range(OUTLINE_POINTS):
        c, s = COSINES[k], SINES[k]
        a = middle_x + along * c * cosine - across * s * sine
        b = middle_y + along * c * sine + across * s * cosine
        da, db = -along * s * cosine - across * c * sine, -along * s * sine + across * c * cosine
        u, v = distorted(lens, a, b)
        u, v = u - shift_x, v - shift_y
        uu, uv, vu, vv = distortion_slopes(lens, a, b)
        du, dv = uu * da + uv * db, vu * da + vv * db
        swept = u * dv - v * du
        area += swept
        moment_x += u * swept
        moment_y += v * swept
    if not area > 0.0:
        return np.nan, np.nan, np.nan
    pixel_x = lens[2] + lens[0] * (shift_x + 2.0 / 3.0 * moment_x / area)
    pixel_y = lens[3] + lens[1] * (shift_y + 2.0 / 3.0 * moment_y / area)
    area *= math.pi / OUTLINE_POINTS * lens[0] * lens[1]
    return pixel_x, pixel_y, math.sqrt(area / math.pi)


@kernel
def positions_of(lens, measured, covariances, radius, positions, spreads):
    """Write where spheres are that are seen as `measured`, and their covariances.

    Return FOUND; NO_DISC if one of the measured is not finite or has no size; NO_SPHERE if no
    sphere looks like one of them.

    Args:
        lens: as that of `discs`.
        measured: (n, 3), x, y, radius, px.
        covariances: (n, 3, 3), of the measured, or (1, 3, 3) of each.
        radius: of the spheres, m.
        positions: (n, 3), to be written.
        spreads: (n, 3, 3), to be written.
    """
    slopes, inverse = np.empty((3, 3)), np.empty((3, 3))
    for i in range(measured.shape[0]):
        x, y, r = measured[i, 0], measured[i, 1], measured[i, 2]
        if not (math.isfinite(x + y + r) and r > 0.0):
            return NO_DISC
    for i in range(measured.shape[0]):
        x, y, z, is_found = position_of(lens, measured[i], radius, slopes)
        if not is_found:
            return NO_SPHERE
        positions[i, 0], positions[i, 1], positions[i, 2] = x, y, z
        invert3(slopes, inverse)
        carry(inverse, covariances[i if covariances.shape[0] > 1 else 0], spreads[i])
    return FOUND


@kernel
def position_of(lens, measured, radius, slopes):
    """Return where a sphere is that is seen as `measured`, and whether there is one.

    `slopes` becomes d (x, y, radius) / d position.
    """
    a, b = undistorted(lens, measured[0], measured[1])
    uu, uv, vu, vv = distortion_slopes(lens, a, b)
    area = math.pi * measured[2] ** 2 / (lens[0] * lens[1] * abs(uu * vv - uv * vu))
    x, y, z = plane_inverse(a, b, area, radius)
    error = np.inf
    for _ in range(NEWTON_STEPS):
        picture_slopes(lens, x, y, z, radius, slopes)
        u, v, r = disc(lens, x, y, z, radius)
        du, dv, dr = measured[0] - u, measured[1] - v, measured[2] - r
        error = abs(du) + abs(dv) + abs(dr)
        if not error > SMALLEST_ERROR:
            break
        dx, dy, dz = solve3(slopes, du, dv, dr)
        x, y, z = x + dx, y + dy, z + dz
    return x, y, z, error < LARGEST_ERROR and math.isfinite(x + y + z)


@kernel
def shapes(lens, pixels, out):
    """Write the shape of a small sphere's outline at each pixel.

    That of d pixel / d (direction's two angles).
    """
    bent = np.empty((2, 2))
    for i in range(pixels.shape[0]):
        a, b = undistorted(lens, pixels[i, 0], pixels[i, 1])
        uu, uv, vu, vv = distortion_slopes(lens, a, b)
        squared = a * a + b * b
        length = math.sqrt(1.0 + squared)
        stretch = (length - 1.0) / squared if squared > 0.0 else 0.0  # Eq. (2) with rho -> 0
        aa, ab, bb = 1.0 + stretch * a * a, stretch * a * b, 1.0 + stretch * b * b
        bent[0, 0], bent[0, 1] = lens[0] * (uu * aa + uv * ab), lens[0] * (uu * ab + uv * bb)
        bent[1, 0], bent[1, 1] = lens[1] * (vu * aa + vv * ab), lens[1] * (vu * ab + vv * bb)
        symmetrise(bent, out[i])


@kernel
def symmetric(matrices, out):
    """Write `symmetrise` of each matrix, (n, 2, 2)."""
    for i in range(matrices.shape[0]):
        symmetrise(matrices[i], out[i])


@kernel
def symmetrise(m, out):
    """Write the symmetric matrix of determinant 1 that draws the same ellipse, but for its size."""
    size = abs(m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0])
    aa = (m[0, 0] * m[0, 0] + m[0, 1] * m[0, 1]) / size
    ab = (m[0, 0] * m[1, 0] + m[0, 1] * m[1, 1]) / size
    bb = (m[1, 0] * m[1, 0] + m[1, 1] * m[1, 1]) / size
    scale = 1.0 / math.sqrt(aa + bb + 2.0)
    out[0, 0], out[0, 1] = scale * (aa + 1.0), scale * ab
    out[1, 0], out[1, 1] = scale * ab, scale * (bb + 1.0)


@kernel
def plane_inverse(a, b, area, radius):
    """Return the sphere whose outline on the plane Z = 1 has this centre and area.

    A fixed point of  s^2 cos rho = area / pi (n_z^2 - s^2)^1.5,  n_xy = (a, b) (n_z^2 - s^2) / n_z:
    each step shrinks the error by about s^2 = sin^2 rho.
    """
    nz = 1.0 / math.sqrt(1.0 + a * a + b * b)
    sin2 = 0.0
    for _ in range(FIXED_POINT_STEPS):
        depth = max(nz * nz - sin2, SMALLEST_DEPTH)
        before = sin2
        sin2 = min(area / math.pi * depth**1.5 / math.sqrt(1.0 - sin2), 0.5)
        scale = max(nz * nz - sin2, SMALLEST_DEPTH) / nz
        nz = math.sqrt(max(1.0 - (a * a + b * b) * scale * scale, SMALLEST_DEPTH))
        if abs(sin2 - before) < 1e-15:
            break
    scale = (nz * nz - sin2) / nz
    distance = radius / math.sqrt(sin2)
    return a * scale * distance, b * scale * distance, nz * distance


@kernel
def picture_slopes(lens, x, y, z, radius, slopes):
    """Write d (x, y, radius) / d position by central differences."""
    step = DIFFERENCE * math.sqrt(x * x + y * y + z * z)
    for k in range(3):
        dx, dy, dz = step * (k == 0), step * (k == 1), step * (k == 2)
        u1, v1, r1 = disc(lens, x + dx, y + dy, z + dz, radius)
        u0, v0, r0 = disc(lens, x - dx, y - dy, z - dz, radius)
        slopes[0, k] = (u1 - u0) / (2.0 * step)
        slopes[1, k] = (v1 - v0) / (2.0 * step)
        slopes[2, k] = (r1 - r0) / (2.0 * step)


@kernel
def solve3(m, a, b, c):
    """Return the solution of m x = (a, b, c) by Cramer's rule; nan if m is singular."""
    k0 = m[1, 1] * m[2, 2] - m[1, 2] * m[2, 1]
    k1 = m[1, 2] * m[2, 0] - m[1, 0] * m[2, 2]
    k2 = m[1, 0] * m[2, 1] - m[1, 1] * m[2, 0]
    determinant = m[0, 0] * k0 + m[0, 1] * k1 + m[0, 2] * k2
    if determinant == 0.0 or not math.isfinite(determinant):
        return np.nan, np.nan, np.nan
    x = a * k0 + b * (m[0, 2] * m[2, 1] - m[0, 1] * m[2, 2])
    x += c * (m[0, 1] * m[1, 2] - m[0, 2] * m[1, 1])
    y = a * k1 + b * (m[0, 0] * m[2, 2] - m[0, 2] * m[2, 0])
    y += c * (m[0, 2] * m[1, 0] - m[0, 0] * m[1, 2])
    z = a * k2 + b * (m[0, 1] * m[2, 0] - m[0, 0] * m[2, 1])
    z += c * (m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0])
    return x / determinant, y / determinant, z / determinant


@kernel
def invert3(m, out):
    """Write the inverse of m, column by column; nan if m is singular."""
    out[0, 0], out[1, 0], out[2, 0] = solve3(m, 1.0, 0.0, 0.0)
    out[0, 1], out[1, 1], out[2, 1] = solve3(m, 0.0, 1.0, 0.0)
    out[0, 2], out[1, 2], out[2, 2] = solve3(m, 0.0, 0.0, 1.0)


@kernel
def carry(m, covariance, out):
    """Write m covariance m^T."""
    for i in range(3):
        for j in range(3):
            out[i, j] = 0.0
            for a in range(3):
                for b in range(3):
                    out[i, j] += m[i, a] * covariance[a, b] * m[j, b]


@kernel
def undistorted(lens, x, y):
    """Return X/Z, Y/Z of a pixel by Newton's method."""
    u, v = (x - lens[2]) / lens[0], (y - lens[3]) / lens[1]
    a, b = u, v
    for _ in range(UNDISTORTION_STEPS):
        p, q = distorted(lens, a, b)
        uu, uv, vu, vv = distortion_slopes(lens, a, b)
        determinant = uu * vv - uv * vu
        if determinant == 0.0:
            return np.nan, np.nan
        da = (vv * (u - p) - uv * (v - q)) / determinant
        db = (uu * (v - q) - vu * (u - p)) / determinant
        a, b = a + da, b + db
        if not abs(da) + abs(db) > SMALLEST_STEP:
            break
    return a, b


@kernel
def distorted(lens, a, b):
    """Return where the lens puts the ray (a, b, 1), in focal lengths."""
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    r2 = a * a + b * b
    q = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = a * q + 2.0 * p1 * a * b + p2 * (r2 + 2.0 * a * a)
    v = b * q + p1 * (r2 + 2.0 * b * b) + 2.0 * p2 * a * b
    return u, v


@kernel
def distortion_slopes(lens, a, b):
    """Return du/da, du/db, dv/da, dv/db of `distorted`."""
    k1, k2, p1, p2, k3 = lens[4], lens[5], lens[6], lens[7], lens[8]
    r2 = a * a + b * b
    q = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2))
    cross = slope * a * b + 2.0 * p1 * a + 2.0 * p2 * b
    uu = q + slope * a * a + 2.0 * p1 * b + 6.0 * p2 * a
    vv = q + slope * b * b + 6.0 * p1 * b + 2.0 * p2 * a
    return uu, cross, cross, vv

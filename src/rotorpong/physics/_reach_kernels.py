"""Where balls pass a plate that flies, compiled; the geometry is in `reach`."""

import numpy as np

from rotorpong.kernels import kernel


@kernel
def crossings(ball, positions, quaternions, plate, hull, out):
    """Write (tick, left, up, clearance) of each track's crossing; nan where there is none.

    Args:
        ball: (n, 3) positions of the ball's centre, one per tick.
        positions: (b, n, 3) centres of mass.
        quaternions: (b, n, 4) body to world.
        plate: (x, y, z, radius): the plate's centre in the body frame, the ball's radius.
        hull: (radius, half height) of a flat cylinder about the centre of mass.
        out: (b, 4).
    """
    x0, y0, z0, radius = plate
    hull_radius, half_height = hull
    for b in range(positions.shape[0]):
        ahead_before, left_before, up_before = np.inf, 0.0, 0.0
        clearance = np.inf
        for k in range(4):
            out[b, k] = np.nan
        for i in range(ball.shape[0]):
            dx = ball[i, 0] - positions[b, i, 0]
            dy = ball[i, 1] - positions[b, i, 1]
            dz = ball[i, 2] - positions[b, i, 2]
            if dx * dx + dy * dy + dz * dz > 4.0:
                continue
            w, x = quaternions[b, i, 0], quaternions[b, i, 1]
            y, z = quaternions[b, i, 2], quaternions[b, i, 3]
            u = (1 - 2 * (y * y + z * z)) * dx + 2 * (x * y + w * z) * dy + 2 * (x * z - w * y) * dz
            v = 2 * (x * y - w * z) * dx + (1 - 2 * (x * x + z * z)) * dy + 2 * (y * z + w * x) * dz
            s = 2 * (x * z + w * y) * dx + 2 * (y * z - w * x) * dy + (1 - 2 * (x * x + y * y)) * dz
            ahead = u - x0 - radius
            if ahead <= 0.0 and ahead_before > 0.0 and np.isfinite(ahead_before):
                f = ahead_before / (ahead_before - ahead)
                out[b, 0] = i - 1 + f
                out[b, 1] = left_before + f * (v - y0 - left_before)
                out[b, 2] = up_before + f * (s - z0 - up_before)
                out[b, 3] = clearance
                break
            radial = max(np.sqrt(u * u + v * v) - hull_radius, 0.0)
            axial = max(abs(s) - half_height, 0.0)
            clearance = min(clearance, np.sqrt(radial * radial + axial * axial) - radius)
            ahead_before, left_before, up_before = ahead, v - y0, s - z0

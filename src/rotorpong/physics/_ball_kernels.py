"""The equations of `ball`, compiled. A state is (position, velocity, spin), nine floats."""

import math

import numpy as np

from rotorpong.conventions import BALL_RADIUS, GRAVITY
from rotorpong.kernels import inlined_kernel, kernel

LANES = 16  # balls that are flown side by side, by vector instructions
AIR_NUMBERS = 4  # of an `Air`
NOTHING = 1e-300  # added to what may be zero, and is to be divided by; changes nothing else


@inlined_kernel
def acceleration(vx, vy, vz, wx, wy, wz, air):
    """Return dv/dt."""
    drag, magnus, _, saturation = air
    squared = vx * vx + vy * vy + vz * vz
    px, py, pz = wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx
    across = math.sqrt(px * px + py * py + pz * pz)
    lift = magnus * squared / (squared + saturation * BALL_RADIUS * across + NOTHING)
    brake = drag * math.sqrt(squared)
    return (
        lift * px - brake * vx,
        lift * py - brake * vy,
        lift * pz - brake * vz - GRAVITY,
    )


@inlined_kernel
def kept(x):
    """Return exp(-x) as RK4 has it: exactly 1 at 0, and to rounding for the x of a step."""
    return 1.0 - x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0)))


@inlined_kernel
def flown_in_lane(x, y, z, vx, vy, vz, wx, wy, wz, dt, air):
    """Return the nine floats of a state after dt, with RK4."""
    h = 0.5 * dt
    ax, ay, az = acceleration(vx, vy, vz, wx, wy, wz, air)
    half = kept(h * air[2])
    mx, my, mz = half * wx, half * wy, half * wz
    bx, by, bz = acceleration(vx + h * ax, vy + h * ay, vz + h * az, mx, my, mz, air)
    cx, cy, cz = acceleration(vx + h * bx, vy + h * by, vz + h * bz, mx, my, mz, air)
    whole = kept(dt * air[2])
    wx, wy, wz = whole * wx, whole * wy, whole * wz
    dx, dy, dz = acceleration(vx + dt * cx, vy + dt * cy, vz + dt * cz, wx, wy, wz, air)
    s, k = dt * dt / 6.0, dt / 6.0
    x = x + dt * vx + s * (ax + bx + cx)
    y = y + dt * vy + s * (ay + by + cy)
    z = z + dt * vz + s * (az + bz + cz)
    vx += k * (ax + 2.0 * bx + 2.0 * cx + dx)
    vy += k * (ay + 2.0 * by + 2.0 * cy + dy)
    vz += k * (az + 2.0 * bz + 2.0 * cz + dz)
    return x, y, z, vx, vy, vz, wx, wy, wz


@kernel
def flown(x, y, z, vx, vy, vz, wx, wy, wz, dt, air):
    """Return what `flown_in_lane` does; compiled once, not into each caller."""
    return flown_in_lane(x, y, z, vx, vy, vz, wx, wy, wz, dt, air)


@kernel
def step(state, dt, air, out):
    """Advance one state by dt with RK4 into `out` (which may be `state`)."""
    x, y, z, vx, vy, vz, wx, wy, wz = flown(
        state[0], state[1], state[2], state[3], state[4], state[5], state[6], state[7], state[8],
        dt, air,
    )  # fmt: skip
    out[0], out[1], out[2] = x, y, z
    out[3], out[4], out[5] = vx, vy, vz
    out[6], out[7], out[8] = wx, wy, wz


@inlined_kernel
def fly_lanes(given, dt, air, to, lanes):
    """Advance states by dt: number k of lane j is at k LANES + j of both arrays.

    The air's numbers for lane j lie so as well.
    """
    for j in range(lanes):
        x, y, z, vx, vy, vz, wx, wy, wz = flown_in_lane(
            given[j], given[LANES + j], given[2 * LANES + j],
            given[3 * LANES + j], given[4 * LANES + j], given[5 * LANES + j],
            given[6 * LANES + j], given[7 * LANES + j], given[8 * LANES + j],
            dt, (air[j], air[LANES + j], air[2 * LANES + j], air[3 * LANES + j]),
        )  # fmt: skip
        to[j], to[LANES + j], to[2 * LANES + j] = x, y, z
        to[3 * LANES + j], to[4 * LANES + j], to[5 * LANES + j] = vx, vy, vz
        to[6 * LANES + j], to[7 * LANES + j], to[8 * LANES + j] = wx, wy, wz


@kernel
def fly(states, air, dt, steps):
    """Advance every state by `steps` steps, in place."""
    given, to, airs = np.zeros(9 * LANES), np.zeros(9 * LANES), np.empty(AIR_NUMBERS * LANES)
    for j in range(LANES):
        airs[j], airs[LANES + j], airs[2 * LANES + j], airs[3 * LANES + j] = air
    for first in range(0, states.shape[0], LANES):
        lanes = min(LANES, states.shape[0] - first)
        for j in range(lanes):
            for k in range(9):
                given[k * LANES + j] = states[first + j, k]
        for _ in range(steps):
            fly_lanes(given, dt, airs, to, lanes)
            given, to = to, given
        for j in range(lanes):
            for k in range(9):
                states[first + j, k] = given[k * LANES + j]


@kernel
def bounce(state, normal, surface_velocity, surface):
    """Change velocity and spin of a ball that touches a moving surface."""
    nx, ny, nz = normal[0], normal[1], normal[2]
    vx = state[3] - surface_velocity[0]
    vy = state[4] - surface_velocity[1]
    vz = state[5] - surface_velocity[2]
    approach = vx * nx + vy * ny + vz * nz
    if approach >= 0.0:
        return
    wx, wy, wz = state[6], state[7], state[8]
    ux = vx - approach * nx - BALL_RADIUS * (wy * nz - wz * ny)
    uy = vy - approach * ny - BALL_RADIUS * (wz * nx - wx * nz)
    uz = vz - approach * nz - BALL_RADIUS * (wx * ny - wy * nx)
    slip = math.sqrt(ux * ux + uy * uy + uz * uz)
    grip = 0.0
    if slip > 0.0:
        limit = surface.friction * (1.0 + surface.restitution) * -approach
        grip = min(0.4, limit / slip)
    jx, jy, jz = -grip * ux, -grip * uy, -grip * uz
    lift = -(1.0 + surface.restitution) * approach
    state[3] += jx + lift * nx
    state[4] += jy + lift * ny
    state[5] += jz + lift * nz
    turn = 1.5 / BALL_RADIUS
    state[6] = wx - turn * (ny * jz - nz * jy)
    state[7] = wy - turn * (nz * jx - nx * jz)
    state[8] = wz - turn * (nx * jy - ny * jx)

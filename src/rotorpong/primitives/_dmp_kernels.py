"""The sum of moving target and response at many instants; the equations are in `dmp.py`."""

from jaxtyping import Float
from numpy import ndarray

from rotorpong.kernels import kernel


@kernel
def sample_motion(
    target: Float[ndarray, "6 d"],
    answer: Float[ndarray, "6 pieces d"],
    x: Float[ndarray, "n"],
    position: Float[ndarray, "n d"],
    slope: Float[ndarray, "n d"],
    curvature: Float[ndarray, "n d"],
) -> None:
    """Write s, ds/dx and d^2 s/dx^2 at the fractions `x` of the duration.

    Args:
        target: coefficients of the quintic g(x).
        answer: on each of the equal pieces of [0, 1], coefficients of eta Phi theta in the
            fraction of the piece.
        x: within [0, 1].
        position: where s goes.
        slope: where ds/dx goes.
        curvature: where d^2 s/dx^2 goes.
    """
    pieces = answer.shape[1]
    for i in range(len(x)):
        q = x[i]
        p = min(int(q * pieces), pieces - 1)
        r = q * pieces - p
        for j in range(target.shape[1]):
            b0, b1, b2 = target[0, j], target[1, j], target[2, j]
            b3, b4, b5 = target[3, j], target[4, j], target[5, j]
            a0, a1, a2 = answer[0, p, j], answer[1, p, j], answer[2, p, j]
            a3, a4, a5 = answer[3, p, j], answer[4, p, j], answer[5, p, j]
            g = b0 + q * (b1 + q * (b2 + q * (b3 + q * (b4 + q * b5))))
            e = a0 + r * (a1 + r * (a2 + r * (a3 + r * (a4 + r * a5))))
            dg = b1 + q * (2 * b2 + q * (3 * b3 + q * (4 * b4 + q * 5 * b5)))
            de = a1 + r * (2 * a2 + r * (3 * a3 + r * (4 * a4 + r * 5 * a5)))
            ddg = 2 * b2 + q * (6 * b3 + q * (12 * b4 + q * 20 * b5))
            dde = 2 * a2 + r * (6 * a3 + r * (12 * a4 + r * 20 * a5))
            position[i, j] = g + e
            slope[i, j] = dg + pieces * de
            curvature[i, j] = ddg + pieces * pieces * dde

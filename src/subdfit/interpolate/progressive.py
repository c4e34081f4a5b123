"""Progressive interpolation (Cheng et al.), and the same iteration with better factors.

The paper's iteration for a mesh V^0, in its notation; by equation 1, B takes vertices to their limit points::

    D^k = V^0 - B V^k,    V^(k+1) = V^k + D^k.

Equation 2 is printed right; the expansion of D^k in section 4 begins with V^0 - V^k, where the limit points B V^k are
meant, and later calls these V^(i+1). Equation 3 then is D^k = (I - B) D^(k-1): the iteration converges when all
eigenvalues of B lie in (0, 1]. Over-relaxation and Chebyshev's iteration multiply D^k by factors chosen from the
smallest eigenvalue.
"""

from collections.abc import Iterator

import numpy as np
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from subdfit.interpolate import _kernels as kernels
from subdfit.interpolate.operator import CHUNK, LimitOperator
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]
Step = tuple[Floats, float]
"""Control points, and the largest distance of one of their limit points from its datum."""

_DENSE = 60
"""Vertices up to which all eigenvalues are computed."""
_ZERO = 1e-8
"""Eigenvalues below are 0."""


def progressive(B: LimitOperator, V0: Floats, V: Floats) -> Iterator[Step]:
    """The paper's iteration: from V = V^0, the meshes V^k, each with the longest vector of its D^k (equation 2)."""
    return _relaxed(B, V0, V, 1.0)


def over_relaxed(B: LimitOperator, V0: Floats, V: Floats) -> Iterator[Step]:
    """V^(k+1) = V^k + w D^k with the best fixed factor, w = 2 / (1 + smallest eigenvalue)."""
    return _relaxed(B, V0, V, 2 / (1 + smallest_eigenvalue(B)))


def chebyshev(B: LimitOperator, V0: Floats, V: Floats) -> Iterator[Step]:
    """Chebyshev's semi-iteration for eigenvalues between the smallest and 1 (Golub and Varga 1961).

    No other iteration that adds combinations of D^0 ... D^k has a better guaranteed error after k steps.
    """
    low = smallest_eigenvalue(B)
    centre, radius = (1 + low) / 2, (1 - low) / 2
    quotient = 1 / centre
    before, share, carry = V, quotient, 0.0
    while True:
        following, D = _corrected(B, V0, V, before, share, carry)
        yield V, D
        V, before = following, V
        last, quotient = quotient, 1 / (2 * centre - radius**2 * quotient)
        share, carry = 2 * quotient, radius**2 * quotient * last


def _relaxed(B: LimitOperator, V0: Floats, V: Floats, factor: float) -> Iterator[Step]:
    while True:
        following, D = _corrected(B, V0, V, V, factor, carry=0.0)
        yield V, D
        V = following


def _corrected(B: LimitOperator, V0: Floats, V: Floats, before: Floats, share: float, carry: float) -> Step:
    """V + share (V0 - B V) + carry (V - before), and the longest vector of V0 - B V."""
    out = np.empty_like(V)
    squares = map_chunks(lambda a, b: kernels.correct(*B.arrays, V0, V, before, share, carry, a, b, out), B.size, CHUNK)
    return out, float(np.sqrt(max(squares)))


def smallest_eigenvalue(B: LimitOperator) -> float:
    """Smallest eigenvalue of B above 0; all are real and in [0, 1] but beside darts, where this is a real part.

    It is one less the largest of I - B, which Arnoldi's method finds well.
    """
    n, wanted = B.size, 1
    complement = spl.LinearOperator((n, n), matvec=lambda x: x - B.matrix @ x, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(n)
    while wanted < n - 1 and n > _DENSE:
        values = 1 - spl.eigs(complement, wanted, which="LR", v0=start, tol=1e-3, return_eigenvectors=False).real
        if values.max() > _ZERO:
            return float(values[values > _ZERO].min())
        wanted *= 2
    everything = np.linalg.eigvals(B.matrix.toarray()).real
    return float(everything[everything > _ZERO].min())

"""Quadrics fitted to a surface near places on it: where it lies, and how it bends, though its points are noisy.

Least squares are repeated with the weights of Geman and McClure 1987, by which points far off count less and less.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.limit.curvature import unit
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]

NEAREST = 40
"""Points to which a quadric is fitted: enough that their noise counts for little."""
_ROUNDS = 4
"""Rounds in which points far off the quadric get less weight."""
_DOUBTED = 2.0
"""Standard deviations of the noise off the quadric at which a point has a quarter of its weight."""
_SURE = 3.0
"""Standard errors from which on curvature is no chance."""
_STIFFNESS = 1e-3
"""Weight of small coefficients, which only decides where the points do not."""
_CHUNK = 1024


@dataclass(frozen=True)
class LocalQuadrics:
    """A quadric, a height over a plane, for each of some places.

    Attributes
    ----------
    distance : (q,) float64, of the place along the quadric's normal.
    spread : (q,) float64, standard deviation of that distance for noise of 1: the more, the farther off the points are.
    normals : (q, 3) float64, unit vectors to either side.
    tensors : (q, 3, 3) float64, the shape operator: positive where the surface is convex, seen from that side; 0 where
        the points may as well be those of a plane.
    """

    distance: Floats
    spread: Floats
    normals: Floats
    tensors: Floats


def local_quadrics(points: Floats, places: Floats, noise: float) -> LocalQuadrics:
    """Quadrics nearest to the points round each place; single points of another surface among them count little.

    Parameters
    ----------
    points : (n, 3) float64, of one smooth surface, n >= `NEAREST`.
    places : (q, 3) float64.
    noise : standard deviation of the points.
    """
    count = len(places)
    found = LocalQuadrics(np.empty(count), np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3)))
    near = np.asarray(cKDTree(points).query(places, k=NEAREST)[1], np.int64)

    def fit(start: int, stop: int) -> None:
        part = _fitted(points[near[start:stop]], places[start:stop], noise)
        found.distance[start:stop], found.spread[start:stop] = part.distance, part.spread
        found.normals[start:stop], found.tensors[start:stop] = part.normals, part.tensors

    map_chunks(fit, count, _CHUNK)
    return found


def _fitted(near: Floats, places: Floats, noise: float) -> LocalQuadrics:
    """The quadrics of places (q, 3), each with its own points (q, k, 3)."""
    middle = near.mean(axis=1)
    frame = np.linalg.svd(near - middle[:, None], full_matrices=False)[2]
    at = np.einsum("qij,qkj->qki", frame, near - middle[:, None])
    own = np.einsum("qij,qj->qi", frame, places - middle)
    size = np.abs(at).max(axis=(1, 2))
    terms, here = _terms(at[..., :2] / size[:, None, None]), _terms(own[:, :2] / size[:, None])
    weights = np.ones(at.shape[:2])
    for _ in range(_ROUNDS):
        form = np.einsum("qk,qki,qkj->qij", weights, terms, terms) + _STIFFNESS * np.eye(terms.shape[-1])
        inverse = np.linalg.inv(form)
        heights = np.einsum("qij,qk,qkj,qk->qi", inverse, weights, terms, at[..., 2], optimize=True)
        off = at[..., 2] - np.einsum("qki,qi->qk", terms, heights)
        weights = 1 / (1 + (off / (_DOUBTED * noise)) ** 2) ** 2
    (u, v), (_, a, b, aa, ab, bb) = own[:, :2].T / size, heights.T
    slope = np.stack([a + 2 * aa * u + ab * v, b + ab * u + 2 * bb * v], axis=1) / size[:, None]
    bend = np.stack([2 * aa, ab, ab, 2 * bb], axis=1).reshape(-1, 2, 2) / (size**2)[:, None, None]
    steep = np.sqrt(1 + np.sum(slope**2, axis=1))
    height = own[:, 2] - np.einsum("qi,qi->q", here, heights)
    spread = np.sqrt(1 + np.einsum("qi,qij,qj->q", here, inverse, here))
    tangents = frame[:, :2] + slope[:, :, None] * frame[:, 2:]
    # Dual to the tangents: it takes vectors of the tangent plane to their coordinates.
    dual = np.linalg.pinv(tangents)
    tensors = -np.einsum("qia,qab,qjb->qij", dual, bend / steep[:, None, None], dual)
    error = 2 * noise * np.sqrt(np.diagonal(inverse, axis1=1, axis2=2)[:, 3:].max(axis=1)) / size**2
    tensors[np.linalg.norm(tensors, axis=(1, 2)) < _SURE * error] = 0.0
    return LocalQuadrics(
        height / steep, spread, unit(frame[:, 2] - np.einsum("qa,qaj->qj", slope, frame[:, :2])), tensors
    )


def _terms(at: Floats) -> Floats:
    """What a quadric's height is a sum of, at coordinates (..., 2), (..., 6)."""
    u, v = at[..., 0], at[..., 1]
    return np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)

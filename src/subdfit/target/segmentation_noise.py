"""Noise of a mesh: how large it is, and the mesh without most of it.

Noise turns triangles by its size over their height: where edges are short, anyhow. Those edges are shrunk to points
first. Then normals are averaged with those near them that are alike, so that creases stay, and vertices are moved until
the triangles have these normals (Zheng, Fu, Au and Tai, Bilateral normal filtering for mesh denoising, 2011; Sun,
Rosin, Martin and Langbein, Fast and effective feature-preserving mesh denoising, 2007).
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from subdfit.limit.curvature import unit
from subdfit.mesh.short_edges import Coarsened, without_short_edges
from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.normals import face_normals
from subdfit.target.segmentation_facets import FLAT

Floats = NDArray[np.float64]
Triangles = NDArray[np.int32]
Creases = NDArray[np.int64]

_TURN = 1.0
"""Degrees by which noise turns half of the triangles at least, or nothing is done about it."""
_FEW = 0.05
"""Noise leaves no more than this share of the edges as flat as within a plane."""
_SMOOTHEST = 0.05
"""Share of the places that are the smoothest: of these the roughest counts."""
_ALIKE = 2.0
"""Noise is alike everywhere: it is called that if half of the places lie within as many times the smoothest of them."""
_PLACES = 200
"""Number of places at which noise is measured."""
_RINGS = 3
"""Triangles across so many edges make a place."""
_POINTS = 10
"""Fewest points of a place: a quadric passes through six."""
_SHORT = 10.0
"""Length of the shortest edges that are left, in standard deviations of the noise."""
_HELD = 1e6
"""How many times a vertex of a crease outweighs others."""
_BALL = 25.0
"""Radius of the balls in which normals are averaged, in standard deviations of the noise."""
_UNLIKE = 20.0
"""Degrees between normals from which they count little for one another."""
_ROUNDS = 2
"""Rounds in which normals are averaged."""
_FARTHEST = 3.0
"""Standard deviations of the noise by which a vertex moves at most."""
_STEPS = 20
"""Rounds in which vertices move: noise has short waves, which a few rounds level."""


def noise_of(points: Floats, triangles: Triangles, creases: Creases) -> float:
    """Standard deviation of the noise along the normal; 0 where there is none that matters.

    Measured from what is left of small pieces of surface when quadrics are fitted to them.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int32, rows of `points`.
    creases : (c, 2) int64, edges that bound the pieces.
    """
    edges = mesh_edges(points, triangles)
    inner = edges.valence == 2
    if np.count_nonzero(inner & (edges.angle < FLAT)) > _FEW * np.count_nonzero(inner):
        return 0.0
    pairs = edges.faces[inner & ~edges_among(edges.vertices, creases)]
    left = [_roughness(points[near]) for near in _places(triangles, pairs) if len(near) >= _POINTS]
    if not left:
        return 0.0
    least, half = np.quantile(left, [_SMOOTHEST, 0.5])
    sides, area = _sides_and_areas(points, triangles)
    height = float(np.median(2 * area / np.maximum(sides.max(axis=1), np.finfo(float).tiny)))
    matters = half > np.tan(np.radians(_TURN)) * height and half <= _ALIKE * least
    return float(half) if matters else 0.0


def _places(triangles: Triangles, pairs: NDArray[np.int64]) -> Iterator[NDArray[np.int32]]:
    """Vertices of the triangles round some, which are spread evenly over the rows."""
    count = len(triangles)
    one, other = np.concatenate([pairs, pairs[:, ::-1], np.repeat(np.arange(count), 2).reshape(-1, 2)]).T
    beside = csr_array(coo_array((np.ones(len(one)), (one, other)), shape=(count, count)))
    near = csr_array(beside[np.linspace(0, count - 1, min(count, _PLACES)).astype(np.int64)])
    for _ in range(_RINGS - 1):
        near = csr_array(near @ beside)
    for start, stop in zip(near.indptr[:-1], near.indptr[1:], strict=True):
        yield np.unique(triangles[near.indices[start:stop]])


def _roughness(points: Floats) -> float:
    """Standard deviation of points (k, 3) about the quadric, a height over their plane, that is nearest to them."""
    centred = points - points.mean(axis=0)
    x, y, z = np.linalg.svd(centred, full_matrices=False)[2] @ centred.T
    size = max(float(np.abs(centred).max()), np.finfo(float).tiny)
    u, v = x / size, y / size
    powers = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=1)
    off = z - powers @ np.linalg.lstsq(powers, z)[0]
    return float(np.sqrt(off @ off / (len(points) - powers.shape[1])))


def _sides_and_areas(points: Floats, triangles: Triangles) -> tuple[Floats, Floats]:
    """Lengths of the sides of triangles (m, 3), and their areas (m,)."""
    sides = points[np.roll(triangles, -1, axis=1)] - points[triangles]
    return np.linalg.norm(sides, axis=2), np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def without_noise(points: Floats, triangles: Triangles, creases: Creases, noise: float) -> Coarsened:
    """The mesh with edges that noise could turn anyhow shrunk to points, and with vertices moved to where it is smooth.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int32, rows of `points`, oriented alike, at most two an edge.
    creases : (c, 2) int64, where short edges shrink to points of the crease.
    noise : its standard deviation.
    """
    weights = np.ones(len(points))
    weights[creases] = _HELD
    coarse = without_short_edges(points, triangles, _SHORT * noise, weights)
    normals = _mean_normals(coarse.points, coarse.triangles, _BALL * noise)
    moved = _with_normals(coarse.points, coarse.triangles, normals, _FARTHEST * noise)
    return Coarsened(moved, coarse.triangles, coarse.rows, coarse.merged)


def _mean_normals(points: Floats, triangles: Triangles, radius: float) -> Floats:
    """Normals of triangles (m, 3), averaged with those of like normals within a distance (bilateral filtering)."""
    _, area = _sides_and_areas(points, triangles)
    centres, normals = points[triangles].mean(axis=1), face_normals(points, triangles)
    pairs = cKDTree(centres).query_pairs(radius, output_type="ndarray")
    own = np.arange(len(triangles))
    one, other = np.concatenate([pairs, pairs[:, ::-1], np.stack([own, own], axis=1)]).T
    near = area[other] * (1 - np.sum((centres[one] - centres[other]) ** 2, axis=1) / radius**2)
    for _ in range(_ROUNDS):
        unlike = np.sum((normals[one] - normals[other]) ** 2, axis=1) / np.radians(_UNLIKE) ** 2
        weights = coo_array((near * np.exp(-unlike / 2), (one, other)), shape=(len(own), len(own)))
        normals = unit(csr_array(weights) @ normals)
    return normals


def _with_normals(points: Floats, triangles: Triangles, normals: Floats, farthest: float) -> Floats:
    """Points (n, 3) moved by no more than a distance until triangles have the normals (m, 3)."""
    _, area = _sides_and_areas(points, triangles)
    corner, face = triangles.ravel(), np.repeat(np.arange(len(triangles)), 3)
    total = np.maximum(np.bincount(corner, area[face], len(points)), np.finfo(float).tiny)[:, None]
    moved = points
    for _ in range(_STEPS):
        centres = moved[triangles].mean(axis=1)
        # To the mean of the planes through the centres of the triangles round a vertex.
        planes = np.einsum("fi,fi->f", normals, centres)
        off = planes[face] - np.einsum("ki,ki->k", normals[face], moved[corner])
        pull = csr_array(coo_array((off * area[face], (corner, face)), shape=(len(points), len(triangles))))
        way = moved + pull @ normals / total - points
        far = np.maximum(np.linalg.norm(way, axis=1), np.finfo(float).tiny)
        moved = points + way * np.minimum(1.0, farthest / far)[:, None]
    return np.asarray(moved)

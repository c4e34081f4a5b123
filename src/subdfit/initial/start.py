"""The first control mesh: the target decimated to a number of vertices chosen from the tolerance."""

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.decimate import Decimated, Decimation, decimate
from subdfit.initial.pairing import pair_triangles
from subdfit.initial.reach import within_reach
from subdfit.initial.sheets import Sheets
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes.scheme import Faces
from subdfit.target.bvh import SegmentTree, TriangleTree
from subdfit.target.curves import boundary_edges
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

logger = logging.getLogger(__name__)

LEAST_SHARE, SHARE = 0.01, 0.05
"""The first control mesh has 1 to 5 % of the points (Nishiyama et al. 2008, section 3), as the shape asks for."""
COARSE, FARTHEST = 2.0, 4.0
"""Tolerances by which 99 % of the points may lie off it, and all: details that are farther off would be lost."""
GROWTH = 1.25
"""Factor by which the vertices grow from one try to the next while it lies off by more."""
COARSEST = 10.0
"""A mesh of the largest share that lies off by more tolerances than this is too coarse."""
LARGEST_SHARE = 0.25
"""Share of the points at which doubling ends."""
SLACK = 1.25
"""No point is asked to lie nearer than so many times its distance from the finest mesh that is thinned."""
REFININGS, REACH, DOUBLING = 5, 1.5, 8.0
"""Most times that the mesh is made finer at places where it does not do; within how many sides of the triangles there;
and by how much more points weigh there each time: a mesh of n vertices errs by about n^-3, so that n doubles."""


def start_mesh(
    target: Target,
    vertices: int | None,
    max_error: float | None,
    budget: int | None = None,
    faces: Faces = "triangles",
    weights: Floats | None = None,
) -> ControlMesh:
    """Decimate the target; join the triangles in pairs where the scheme takes quads.

    Parameters
    ----------
    target
        The data, in the normalised frame.
    vertices
        Vertices wanted; None takes as few as leave 99 % of the points within `COARSE` tolerances, but 1 to 5 % of the
        points, and makes the mesh finer where any lies off by more than `FARTHEST`; and up to `LARGEST_SHARE` of them
        while any lies off by more than `COARSEST` tolerances, as happens where thin parts have few points.
    max_error
        The tolerance as a share of the diagonal; None counts as .1 %.
    budget
        Most vertices that are chosen here; None is unbounded.
    faces
        What the scheme takes.
    weights
        What an error at each of the target's points counts, (n,), where `vertices` are given; see `decimate`.

    Raises
    ------
    InputError
        The target has no faces.
    """
    if not target.is_mesh:
        raise InputError("the target has points only; reconstruct a mesh from them first, or give faces")
    used = np.unique(target.triangles)
    row = np.full(len(target.points), -1, np.int64)
    row[used] = np.arange(len(used))
    points, triangles, creases = target.points[used], row[target.triangles], row[target.crease_edges]
    corners = row[target.corners]
    if vertices is not None:
        some = None if weights is None else weights[used]
        found = decimate(points, triangles, vertices, crease_edges=creases, corners=corners, weights=some)
    else:
        bound = max_error or 1e-3
        sheets = None if target.cloud else Sheets(target, bound)
        found = _coarse_enough(points, triangles, creases, corners, bound, budget or len(points), sheets)
    asked = vertices is not None and weights is None
    if found.message and asked:
        logger.warning("%s", found.message)
    mesh = ControlMesh.from_triangles(
        found.points, _one_sided(found.triangles), crease_edges=found.crease_edges, corner_vertices=found.corners
    )
    return mesh if faces == "triangles" else pair_triangles(mesh)


def _one_sided(triangles: Rows) -> Rows:
    """The triangles without the second of two back to back, which have all edges in common.

    Their vertices have two faces each, as no limit surface of triangles allows.
    """
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    return triangles[np.sort(first)]


def _coarse_enough(
    points: Floats, triangles: Rows, creases: Rows, corners: Rows, bound: float, budget: int, sheets: Sheets | None
) -> Decimated:
    """Decimate as far as the tolerance lets a fit begin."""
    wanted = min(max(4, round(SHARE * len(points))), budget)
    most = min(max(4, int(LARGEST_SHARE * len(points))), budget)
    decimation = Decimation(points, triangles, crease_edges=creases, corners=corners)
    dense, found = decimation.down_to(most), decimation.down_to(wanted)
    distance = _distances(points, found)
    while distance.max() > COARSEST * bound and 2 * wanted <= most:
        wanted *= 2
        found = decimate(points, triangles, wanted, crease_edges=creases, corners=corners)
        distance = _distances(points, found)
    return _coarsened(points, triangles, dense, found, distance, bound, sheets)


def _coarsened(
    points: Floats,
    triangles: Rows,
    dense: Decimated,
    found: Decimated,
    distance: Floats,
    bound: float,
    sheets: Sheets | None,
) -> Decimated:
    """Decimate further, as far as the points stay near enough; `distance` (n,) are theirs from what was found."""
    finest, wanted, cloud = found, len(found.points), sheets is None
    # Where much is curved, errors fall as vertices grow; where little is, far more steeply.
    wanted = max(4, round(LEAST_SHARE * len(points)), int(_strain(distance, bound, cloud) * wanted))
    while wanted < len(finest.points):
        coarse = _decimated(finest, wanted, np.ones(len(finest.points)))
        if _strain(_distances(points, coarse), bound, cloud) <= 1:
            most = np.maximum(FARTHEST * bound, SLACK * distance)
            rim = np.unique(boundary_edges(triangles))
            most_of_rim = np.maximum(FARTHEST * bound, SLACK * _distances_of_rim(points[rim], finest))
            wanting = _Wanting(points, most, rim, most_of_rim, FARTHEST * bound, sheets)
            return _finer_where_wanting(wanting, finest, coarse, dense)
        wanted = int(GROWTH * wanted) + 1
    return finest


@dataclass(frozen=True, eq=False)
class _Wanting:
    """Where a coarse mesh does not do.

    Attributes
    ----------
    points, most : the target's points, (n, 3), and how far off each may lie at most, (n,).
    rim, most_of_rim : rows of those on its boundary, (b,), and how far off the mesh's boundary each may lie, (b,).
    size : length of a triangle's side beyond which what mixes up sheets lies farther off than they may be apart.
    sheets : those not to be mixed up, or None.
    """

    points: Floats
    most: Floats
    rim: Rows
    most_of_rim: Floats
    size: float
    sheets: Sheets | None

    def places(self, mesh: Decimated) -> tuple[Floats, Floats, bool]:
        """Such places, (k, 3), how far round each more vertices are needed, (k,), and whether any mixes up sheets."""
        found = TriangleTree(mesh.points, mesh.triangles).closest(self.points)
        far = np.flatnonzero(found.distance > self.most)
        far = np.concatenate([far, self.rim[_distances_of_rim(self.points[self.rim], mesh) > self.most_of_rim]])
        places, reach = self.points[far], _longest(mesh, found.triangle[far])
        if self.sheets is None:
            return places, REACH * reach, False
        mixed, under = self.sheets.mixed(mesh.points, mesh.triangles, found)
        reach = np.concatenate([reach, np.minimum(_longest(mesh, under), self.size)])
        return np.concatenate([places, mixed]), REACH * reach, len(mixed) > 0


def _longest(mesh: Decimated, triangle: NDArray[np.integer]) -> Floats:
    """The longest side of some triangles, (k,)."""
    corners = mesh.points[mesh.triangles[triangle]]
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0))


def _finer_where_wanting(wanting: _Wanting, finest: Decimated, coarse: Decimated, dense: Decimated) -> Decimated:
    """The coarse mesh with more vertices where it does not do; those of a `dense` mesh where it mixes sheets up."""
    source, weights = None, np.empty(0)
    for _ in range(REFININGS):
        places, reach, mixed = wanting.places(coarse)
        if len(places) == 0:
            break
        if source is None:
            source = dense if mixed else finest
            weights = np.ones(len(source.points))
        weights[within_reach(source.points, places, reach)] *= DOUBLING
        wanted = len(coarse.points) + int(within_reach(coarse.points, places, reach).sum())
        if wanted >= len(finest.points):
            return finest if source is finest else coarse
        coarse = _decimated(source, wanted, weights)
    return coarse


def _decimated(mesh: Decimated, wanted: int, weights: Floats) -> Decimated:
    creases, corners = mesh.crease_edges, mesh.corners
    return decimate(mesh.points, mesh.triangles, wanted, crease_edges=creases, corners=corners, weights=weights)


def _strain(distance: Floats, bound: float, all_of_them: bool) -> float:
    """How far points are off, in terms of what a fit may begin with: at most 1 is near enough.

    Of a cloud all points count: from a coarse mesh across its voids, where no points hold it, the surface goes astray.
    """
    farthest = distance.max() / FARTHEST if all_of_them else 0.0
    return float(max(np.quantile(distance, 0.99) / COARSE, farthest) / bound)


def _distances(points: Floats, found: Decimated) -> Floats:
    """Distances of the points from a decimated mesh, (n,)."""
    return TriangleTree(found.points, found.triangles).closest(points).distance


def _distances_of_rim(points: Floats, found: Decimated) -> Floats:
    """Distances of points from the boundary of a decimated mesh, (n,): a loop may shrink within what it bounds."""
    if len(points) == 0:
        return np.empty(0)
    return SegmentTree(found.points, boundary_edges(found.triangles)).closest(points).distance

"""The first control mesh: the target decimated to a number of vertices chosen from the tolerance."""

import logging

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.decimate import Decimated, decimate
from subdfit.initial.pairing import pair_triangles
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes.scheme import Faces
from subdfit.target.bvh import TriangleTree
from subdfit.target.target import Target

logger = logging.getLogger(__name__)

LEAST_SHARE, MOST_SHARE = 0.01, 0.05
"""The first control mesh has 1 to 5 % of the points (Nishiyama et al. 2008, section 3)."""
COARSEST = 10.0
LARGEST_SHARE = 0.25
"""Share of the points at which doubling ends."""


def start_mesh(
    target: Target,
    vertices: int | None,
    max_error: float | None,
    budget: int | None = None,
    faces: Faces = "triangles",
) -> ControlMesh:
    """Decimate the target; join the triangles in pairs where the scheme takes quads.

    Parameters
    ----------
    target
        The data, in the normalised frame.
    vertices
        Vertices wanted; None takes 5 % of the points for tolerances of .05 % of the diagonal and less, 1 % for 1 % and
        more, and in between by the logarithm; and twice as many while the decimated mesh strays from the points by
        more than `COARSEST` tolerances, as thin parts of few points do.
    max_error
        The tolerance as a share of the diagonal; None counts as .1 %.
    budget
        Most vertices that are chosen here; None is unbounded.
    faces
        What the scheme takes.

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
    if vertices is not None:
        found = decimate(points, triangles, vertices, crease_edges=creases)
    else:
        bound = max_error or 1e-3
        most = min(LARGEST_SHARE * len(points), budget or np.inf)
        wanted = int(min(default_vertices(len(points), bound), budget or np.inf))
        found = decimate(points, triangles, wanted, crease_edges=creases)
        while _worst(points, found) > COARSEST * bound and 2 * wanted <= most:
            wanted *= 2
            found = decimate(points, triangles, wanted, crease_edges=creases)
    if found.message:
        logger.warning("%s", found.message)
    mesh = ControlMesh.from_triangles(
        found.points, found.triangles, crease_edges=found.crease_edges, corner_vertices=found.corners
    )
    return mesh if faces == "triangles" else pair_triangles(mesh)


def _worst(points: NDArray[np.float64], found: Decimated) -> float:
    """Largest distance of the points from a decimated mesh."""
    return float(TriangleTree(found.points, found.triangles).closest(points).distance.max())


def default_vertices(points: int, max_error: float) -> int:
    """Vertices to start from, for a number of points and a tolerance as a share of the diagonal."""
    level = float(np.clip(np.log(max_error / 5e-4) / np.log(1e-2 / 5e-4), 0.0, 1.0))
    share: float = MOST_SHARE * (LEAST_SHARE / MOST_SHARE) ** level
    return max(4, round(share * points))

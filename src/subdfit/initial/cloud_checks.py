"""What is said of a cloud that is no sampling of a surface, or may be none."""

import logging

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.errors import InputError
from subdfit.initial.distinct import SINGLE
from subdfit.initial.joined_sheets import share_of_joined_sheets
from subdfit.initial.orient import components_of
from subdfit.mesh.topology import Topology
from subdfit.target.normals import face_normals
from subdfit.wording import counted

logger = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

LEAST_POINTS = 4

ON_LINE = 1e-6
"""Width of a cloud, as a share of its length, below which it is a line."""

MANY_REPEATED = 1 / 3
"""Share of repeats above which coordinates seem to have lost digits."""

LEAST_SHARE = 0.5
"""Share of the points that must be on the surface."""

WARN_SHARE, MOST_SHARE = 0.005, 0.02
"""Handles and holes for each point above which the surface is doubted, and refused: noise makes both by the hundred."""

SOME = 10
"""Handles and holes that a shape of few points may have."""

SMOOTH = 30.0
"""Degrees by which half of the triangles' folds must stay below: the wedge in which a triangle continues another
plausibly (Cohen-Steiner and Da 2004, section 3.2). Random points fold by 40 to 60."""

SOME_EDGES = 20_000
"""At how many edges, at most twice, folds are measured."""

NEAR, FAR, SOME_POINTS = 6, 24, 2000
"""Neighbours whose distances tell the dimension, and at how many points."""

BETWEEN = (1.5, 2.5)
"""Dimension of clouds between curves and surfaces, and between these and solids."""

MANY_JOINED = 0.05
"""Share of the vertices round which two sheets are joined to one from which it is told: five times that of a box."""

LOST = "were digits lost, by a large offset or a coarse unit"
REMEDY = "is noisy or too sparse for the shape, or an axis is in another unit: give denser points, or check the scale"


def check_extent(points: Floats, given: int, name: str) -> None:
    """Refuse distinct points (n, 3), of `given`, that span no surface."""
    if len(points) < LEAST_POINTS:
        lost = f" among {given:,} ({LOST}?)" if len(points) < given else ""
        raise InputError(
            f"{name}: has {counted(len(points), 'distinct point')}{lost}; a surface needs at least {LEAST_POINTS}"
        )
    extent = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extent[1] <= ON_LINE * extent[0]:
        raise InputError(
            f"{name}: all points lie on a line; a surface needs points beside it, or is an axis in another unit?"
        )


def check_joined(points: Floats, triangles: Rows, name: str) -> None:
    """Refuse triangles that leave out most of the points."""
    used = np.count_nonzero(np.bincount(triangles.ravel(), minlength=len(points)))
    if used < LEAST_SHARE * len(points):
        where = "they lie along curves; " if _dimension(points) < BETWEEN[0] else ""
        raise InputError(
            f"{name}: only {used:,} of {len(points):,} points lie on a surface; {where}the sampling {REMEDY}"
        )


def check_surface(points: Floats, triangles: Rows, name: str) -> None:
    """Warn of a surface with many handles and holes, of two sheets joined to one, and of what is rough or fills space.

    Raises
    ------
    InputError
        There are more handles and holes than any sampled shape has.
    """
    topology = Topology.from_triangles(triangles, len(points))
    tangles = _tangles(topology)
    text = f"{name}: the surface through the points has {tangles:,} handles and holes; the sampling {REMEDY}"
    if tangles > 2 * SOME + MOST_SHARE * len(points):
        raise InputError(text)
    if tangles > SOME + WARN_SHARE * len(points):
        logger.warning("%s", text)
    elif _dimension(points) > BETWEEN[1]:
        logger.warning("%s: the points fill space, or sheets lie nearer than points; the sampling %s", name, REMEDY)
    elif (share := share_of_joined_sheets(points, topology, SINGLE)) > MANY_JOINED:
        logger.warning(
            "%s: at %.0f %% of the vertices two sheets lie nearer than the points, and are joined to one that zigzags; "
            "the shape is thin there, or an axis is in another unit: give denser points, or check the scale",
            name,
            100 * share,
        )
    elif (fold := _median_fold(points, topology)) > SMOOTH:
        logger.warning(
            "%s: half of the folds between triangles exceed %.0f degrees; the sampling %s", name, fold, REMEDY
        )


def tell(left_out: int, repeated: int, given: int, name: str) -> None:
    """Count points that repeat another's position, and those that are left out."""
    lost = repeated > MANY_REPEATED * given
    if repeated:
        logger.log(
            logging.WARNING if lost else logging.INFO,
            "%s: of %s %s the position of another%s",
            name,
            counted(given, "point"),
            counted(repeated, "repeats", "repeat"),
            f"; is all there twice, or {LOST}?" if lost else "",
        )
    if left_out:
        logger.warning("%s: %s on no surface, left out", name, counted(left_out, "point"))


def _tangles(topology: Topology) -> int:
    """Handles and holes of all components, handles counted twice."""
    _, components = components_of(topology.triangles, topology.vertex_count)
    return 2 * components - (topology.vertex_count - topology.edge_count + topology.face_count)


def _median_fold(points: Floats, topology: Topology) -> float:
    """Degrees between neighbouring triangles, in the middle of some."""
    inner = np.flatnonzero(topology.twin >= 0)
    if not len(inner):
        return 0.0
    some = inner[:: -(-len(inner) // SOME_EDGES)]
    a, b = (face_normals(points, topology.triangles[topology.face[h]]) for h in (some, topology.twin[some]))
    cosine = np.einsum("kd,kd->k", a, b)
    return float(np.degrees(np.arccos(np.clip(np.median(cosine), -1.0, 1.0))))


def _dimension(points: Floats) -> float:
    """Power of the radius with which the number of neighbours grows: 1 along curves, 2 on surfaces, 3 in space."""
    if len(points) <= FAR:
        return 2.0
    some = points[:: -(-len(points) // SOME_POINTS)]
    distance = np.asarray(cKDTree(points).query(some, [NEAR + 1, FAR + 1])[0])
    growth = float(np.median(distance[:, 1] / distance[:, 0]))
    return float(np.log(FAR / NEAR) / np.log(growth)) if growth > 1.0 else np.inf

"""A first control mesh of an open surface from its boundaries and lines of curvature.

Lavoué, Dupont and Baskurt 2007, section 4.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.lavoue_contour import topologic_contour
from subdfit.initial.lavoue_cutting import Cutting
from subdfit.initial.lavoue_scores import Paths, ScoredSurface, require_paths
from subdfit.mesh.checks import finite_points, triangle_rows
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.curvature import curvature_field
from subdfit.target.curves import boundary_loops

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BoundaryPolygon:
    """The control polygon of one boundary, in the direction that has the surface on its left.

    Attributes
    ----------
    points : (k, 3) float64, k >= 3.
    corners : (k,) bool, which of them stay in place.
    limits : (k, 3) float64, their limits on the boundary curve.

    Raises
    ------
    InputError
        Fewer than three points, one that is not finite, or not one flag and one limit for each.
    """

    points: Floats
    corners: NDArray[np.bool_]
    limits: Floats

    def __post_init__(self) -> None:
        points, corners = finite_points(self.points, "polygon"), np.asarray(self.corners)
        limits = finite_points(self.limits, "polygon's limits")
        if len(points) < 3:
            raise InputError(f"a polygon of {len(points)} control points; give 3 or more")
        if len(limits) != len(points):
            raise InputError(f"{len(limits)} limits for the {len(points)} control points of a polygon; give one each")
        if corners.shape != (len(points),) or corners.dtype != np.bool_:
            raise InputError(
                f"corners are {corners.dtype} of the shape {corners.shape} for the {len(points)} control points of a "
                "polygon; give one bool each"
            )
        for name, value in (("points", points), ("corners", corners), ("limits", limits)):
            object.__setattr__(self, name, value)


def boundary_start(
    points: Floats,
    triangles: NDArray[np.integer],
    polygons: Sequence[BoundaryPolygon],
    *,
    paths: Paths = "geodesic",
    radius: float | None = None,
    most_corners: int = 4,
) -> ControlMesh:
    """Control mesh of triangles and quads whose vertices are the control points of the boundaries.

    Parameters
    ----------
    points, triangles : the surface: connected, oriented, with at least one boundary and without handles. Points of no
        triangle do not count.
    polygons : one for each boundary, in the order of `boundary_loops`.
    paths : of possible edges, see `ScoredSurface`.
    radius : over which curvature is averaged; see `curvature_field`.
    most_corners : of a face, 3 or more.

    Raises
    ------
    InputError
        A row that is no point, a point that is not finite, the surface is closed or has handles, there are too few
        control points for its holes, or an option cannot be.
    """
    require_paths(paths)
    if most_corners < 3:
        raise InputError(f"most_corners is {most_corners}; give 3 or more")
    points = finite_points(points, "mesh")
    used, rows = np.unique(triangle_rows(triangles, len(points)), return_inverse=True)
    points, triangles = points[used], rows.reshape(-1, 3)
    loops = boundary_loops(triangles)
    if len(loops) != len(polygons):
        raise InputError(f"{len(polygons)} polygons for {len(loops)} boundaries; give one each")
    if not loops:
        raise InputError("the surface is closed; segment it into open patches first")
    surface = ScoredSurface(points, triangles, curvature_field(points, triangles, radius), paths)
    anchors = np.concatenate([_anchors(points, loop.vertices, p) for loop, p in zip(loops, polygons, strict=True)])
    loop_of = np.repeat(np.arange(len(polygons)), [len(p.points) for p in polygons])
    controls, limits = (np.concatenate([getattr(p, what) for p in polygons]) for what in ("points", "limits"))
    contour = topologic_contour(surface, anchors, loop_of, controls)
    cutting = Cutting(contour, controls[contour.controls], limits[contour.controls], most_corners)
    rings = cutting.faces()
    if cutting.stuck:
        raise InputError("the boundary has too few control points for its holes; ask for a smaller tolerance")
    faces = [contour.controls[ring] for ring in rings]
    topology = Topology.from_faces(
        np.concatenate([[0], np.cumsum([len(face) for face in faces])]),
        np.concatenate(faces),
        len(anchors),
        corner_vertices=np.flatnonzero(np.concatenate([p.corners for p in polygons])),
    )
    return ControlMesh(topology, controls, "quad-triangle")


def _anchors(points: Floats, loop: NDArray[np.int64], polygon: BoundaryPolygon) -> NDArray[np.int64]:
    """A boundary vertex of its own for each control point, near its limit."""
    if len(loop) < len(polygon.points):
        raise InputError(
            f"a boundary of {len(loop)} vertices has {len(polygon.points)} control points; refine the mesh"
        )
    from scipy.optimize import linear_sum_assignment  # takes long to load, and few fits need it

    squares = np.sum((polygon.limits[:, None] - points[loop][None]) ** 2, axis=2)
    return loop[linear_sum_assignment(squares)[1]]

"""The limit surface as callers meet it: evaluated, searched and tessellated in their own unit."""

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.api.cages import control_mesh_of
from subdfit.api.sources import MeshSource
from subdfit.api.targets import check_count
from subdfit.closest.projection import Projection, Projector
from subdfit.errors import InputError
from subdfit.limit import surface as limit
from subdfit.limit.tessellate import lattice, lattice_apart, manifold_triangles
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import Scheme, scheme_named
from subdfit.target.frame import Frame

Floats = NDArray[np.float64]


class Tessellation(NamedTuple):
    """Triangles on a limit surface.

    Attributes
    ----------
    points : (n, 3) float64, on the surface, in the control points' unit.
    triangles : (t, 3) int32, rows of `points`, oriented as the control mesh.
    normals : (n, 3) float64, the surface's unit normals; where a vertex is shared across a crease, those of one side.
    """

    points: Floats
    triangles: NDArray[np.int32]
    normals: Floats


class LimitSurface(limit.LimitSurface):
    """The limit surface of a control mesh.

    Parameters
    ----------
    control_mesh
        A `ControlMesh`, or anything one is made of: a path, ``(vertices, faces)``, a trimesh or PyVista object.
    scheme
        A scheme's name; None takes the mesh's own, else Loop where all faces are triangles, Catmull-Clark elsewhere.

    Raises
    ------
    InputError
        The mesh cannot be read, or the scheme cannot take it.

    Examples
    --------
    >>> import numpy as np
    >>> octahedron = (
    ...     np.vstack([np.eye(3), -np.eye(3)]),
    ...     [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
    ... )
    >>> surface = LimitSurface(octahedron)
    >>> found = surface.closest([[2.0, 0.0, 0.0]])
    >>> surface.evaluate(found.face, found.uv).position.round(4) + 0.0
    array([[0.4364, 0.    , 0.    ]])
    """

    def __init__(self, control_mesh: ControlMesh | MeshSource, scheme: str | Scheme | None = None) -> None:
        name = None if scheme is None else scheme_named(scheme).name
        super().__init__(control_mesh_of(control_mesh, name), scheme)

    def closest(self, points: ArrayLike) -> Projection:
        """Find the nearest point of the surface to each given point, globally.

        Parameters
        ----------
        points
            (k, 3), in the control points' unit.

        Returns
        -------
        Projection
            Faces, parameters, and distances in the control points' unit.

        Raises
        ------
        InputError
            Another shape, or a coordinate that is not finite.
        """
        data = np.asarray(points, np.float64)
        if data.ndim != 2 or data.shape[1] != 3 or not np.isfinite(data).all():
            raise InputError(f"closest needs finite points of shape (k, 3); got an array of shape {data.shape}")
        frame = self._frame
        found = self._projector.certain(frame.inside(data))
        return Projection(found.face, found.uv, found.distance * frame.diagonal, found.converged)

    def tessellate(self, level: int, *, apart: bool = False) -> Tessellation:
        """Cut a triangle cell into ``4**level`` triangles, a quad into twice as many, all vertices on the surface.

        Parameters
        ----------
        level
            0 to 8.
        apart
            Cut the triangles apart along creases: a vertex on a crease comes once for each side, with the normal of
            that side, as drawing needs it. Otherwise triangles share all vertices, and are a manifold.

        Raises
        ------
        InputError
            `level` is no whole number from 0 to 8.
        """
        check_count(level, "level", 0)
        if level > 8:
            raise InputError(f"level is {level}, which would make {4**level:,} triangles a face; give 8 or less")
        segments = 2**level
        grid = lattice(self.domain, segments)
        points = self.evaluate(grid.face, grid.uv).position
        if apart:
            sides = lattice_apart(self.domain, segments)
            copies = np.empty((len(sides.face), 3))
            copies[sides.triangles] = points[grid.triangles]
            return Tessellation(copies, sides.triangles, self.normals(sides.face, sides.uv))
        triangles = manifold_triangles(self.domain, segments, grid)
        return Tessellation(points, triangles, self.normals(grid.face, grid.uv))

    @cached_property
    def _frame(self) -> Frame:
        return Frame.of(self.control_mesh.points)

    @cached_property
    def _projector(self) -> Projector:
        """Search in normalised coordinates, in which a surface far from the origin loses nothing."""
        return Projector(self.with_points(self._frame.inside(self.control_mesh.points)))

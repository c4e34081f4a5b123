"""The data of a fit: points in the normalised frame, which of them lie on curves, what each is allowed."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.target.frame import Frame
from subdfit.target.sampling import face_samples
from subdfit.target.target import Target

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FitData:
    """What is to be fitted, in the normalised frame.

    Attributes
    ----------
    points : (k, 3), the target's used vertices, then samples inside large faces.
    vertices : how many of them are vertices.
    allowance : (k,), what a point may lie off beyond the tolerance: 0 for vertices, a sample's face's sagitta.
    boundary, crease : rows of the points that lie on the target's boundary, on its creases.
    """

    points: Floats
    vertices: int
    allowance: Floats
    boundary: NDArray[np.int64]
    crease: NDArray[np.int64]

    @classmethod
    def of(cls, target: Target, frame: Frame, spacing: float) -> "FitData":
        """Gather the data of a target; faces with sides longer than `spacing` (normalised) get samples inside."""
        used = target.used
        row = np.full(len(target.points), -1, np.int64)
        row[used] = np.arange(len(used))
        points, allowance = frame.inside(target.points[used]), np.zeros(len(used))
        if target.is_mesh:
            triangle, uv = face_samples(target.points, target.triangles, spacing * frame.diagonal)
            corners = target.points[target.triangles[triangle]]
            weights = np.column_stack([1 - uv.sum(axis=1), uv])
            points = np.concatenate([points, frame.inside(np.einsum("kc,kcd->kd", weights, corners))])
            allowance = np.concatenate([allowance, target.sagitta[triangle] / frame.diagonal])
        boundary = np.unique(row[target.boundary_edges])
        crease = np.setdiff1d(np.unique(row[target.crease_edges]), boundary)
        return cls(points, len(used), allowance, boundary, crease)

    @property
    def surface_rows(self) -> NDArray[np.bool_]:
        """Which points pull at the surface rather than at a curve, (k,)."""
        inside = np.ones(len(self.points), np.bool_)
        inside[self.boundary] = False
        inside[self.crease] = False
        return inside

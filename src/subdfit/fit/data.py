"""The data of a fit: points in the normalised frame, which of them lie on curves, what each is allowed."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

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
    target : the target itself, in the normalised frame.
    """

    points: Floats
    vertices: int
    allowance: Floats
    boundary: NDArray[np.int64]
    crease: NDArray[np.int64]
    target: Target

    @classmethod
    def of(cls, target: Target, spacing: float) -> "FitData":
        """Gather the data of a normalised target; faces with sides longer than `spacing` get samples inside."""
        used = target.used
        row = np.full(len(target.points), -1, np.int64)
        row[used] = np.arange(len(used))
        points, allowance = target.points[used], np.zeros(len(used))
        if target.is_mesh:
            triangle, uv = face_samples(target.points, target.triangles, spacing)
            points = np.concatenate([points, target.on_triangles(triangle, uv)])
            if len(triangle):
                allowance = np.concatenate([allowance, target.sagitta[triangle]])
        boundary = np.unique(row[target.boundary_edges])
        crease = np.setdiff1d(np.unique(row[target.crease_edges]), boundary)
        return cls(points, len(used), allowance, boundary, crease, target)

    def subset(self, rows: NDArray[np.int64]) -> "FitData":
        """The data of some rows, ascending."""
        number = np.full(len(self.points), -1, np.int64)
        number[rows] = np.arange(len(rows))
        boundary, crease = number[self.boundary], number[self.crease]
        return FitData(
            self.points[rows],
            int(np.searchsorted(rows, self.vertices)),
            self.allowance[rows],
            boundary[boundary >= 0],
            crease[crease >= 0],
            self.target,
        )

    @cached_property
    def spacing(self) -> float:
        """Mean length of the target's edges; 0 for a cloud."""
        if not self.target.is_mesh:
            return 0.0
        corners = self.target.points[self.target.triangles]
        return float(np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean())

    @property
    def surface_rows(self) -> NDArray[np.bool_]:
        """Which points pull at the surface rather than at a curve, (k,)."""
        inside = np.ones(len(self.points), np.bool_)
        inside[self.boundary] = False
        inside[self.crease] = False
        return inside

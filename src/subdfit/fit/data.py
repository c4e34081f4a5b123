"""The data of a fit: points in the normalised frame, which of them lie on curves, what each is allowed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from subdfit.target.curves import directions
from subdfit.target.normals import face_normals
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
    granted : (k,), what a point may lie off beyond the tolerance: 0 for vertices, the sagitta there for samples.
    triangle : (k,), the target's triangle that holds a sample, -1 for vertices.
    left_out : (k,) bool, outliers, and samples of their triangles.
    normals : (k, 3), the target's unit normals there; zero where they are not known.
    boundary, crease : rows of the points that lie on the target's boundary, on its creases.
    along : (b, 3), unit directions of the boundary at its points, the triangles on its left; zero where unclear.
    target : the target itself, in the normalised frame.
    spacing : mean length of the target's edges, none counted as longer than samples inside faces are apart; 0 for a
        cloud.
    bound : the error that matters: sheets and curves nearer to a point need not be told apart.
    """

    points: Floats
    vertices: int
    granted: Floats
    triangle: NDArray[np.int64]
    left_out: NDArray[np.bool_]
    normals: Floats
    boundary: NDArray[np.int64]
    crease: NDArray[np.int64]
    along: Floats
    target: Target
    spacing: float
    bound: float

    @classmethod
    def of(cls, target: Target, spacing: float, bound: float = 0.0) -> "FitData":
        """Gather the data of a normalised target; faces with sides longer than `spacing` get samples inside."""
        used = target.used
        row = np.full(len(target.points), -1, np.int64)
        row[used] = np.arange(len(used))
        points, granted, normals = target.points[used], np.zeros(len(used)), target.normals[used]
        holder = np.full(len(used), -1, np.int64)
        if target.is_mesh and not target.cloud:
            triangle, uv = face_samples(target.points, target.triangles, spacing)
            points = np.concatenate([points, target.on_triangles(triangle, uv)])
            if len(triangle):
                granted = np.concatenate([granted, target.sagitta(triangle, uv)])
                holder = np.concatenate([holder, triangle])
                normals = np.concatenate([normals, face_normals(target.points, target.triangles[triangle])])
        boundary = _known(row[target.boundary_edges])
        crease = np.setdiff1d(_known(row[target.crease_edges]), boundary)
        along = directions(target.points, target.boundary_edges)[used[boundary]]
        mean = _mean_spacing(target, spacing)
        none = np.zeros(len(points), np.bool_)
        return cls(points, len(used), granted, holder, none, normals, boundary, crease, along, target, mean, bound)

    def subset(self, rows: NDArray[np.int64]) -> "FitData":
        """The data of some rows, ascending."""
        number = np.full(len(self.points), -1, np.int64)
        number[rows] = np.arange(len(rows))
        boundary, crease = number[self.boundary], number[self.crease]
        return FitData(
            self.points[rows],
            int(np.searchsorted(rows, self.vertices)),
            self.granted[rows],
            self.triangle[rows],
            self.left_out[rows],
            self.normals[rows],
            boundary[boundary >= 0],
            crease[crease >= 0],
            self.along[boundary >= 0],
            self.target,
            self.spacing,
            self.bound,
        )

    def without(self, outliers: NDArray[np.int64]) -> "FitData":
        """The same data with these vertices left out, and no others; the triangles that they hold stand for nothing."""
        out = np.zeros(len(self.points), np.bool_)
        out[outliers] = True
        held = self.target.triangles[self.triangle[self.vertices :]]
        out[self.vertices :] = np.isin(held, self.target.used[outliers]).any(axis=1)
        return replace(self, left_out=out)

    @cached_property
    def allowance(self) -> Floats:
        """What a point may lie off beyond the tolerance, (k,): infinitely far where it is left out."""
        return np.where(self.left_out, np.inf, self.granted)

    @cached_property
    def suspects(self) -> NDArray[np.int64]:
        """Vertices that the target's triangles leave out."""
        on_mesh = np.zeros(len(self.target.points), np.bool_)
        on_mesh[self.target.triangles] = True
        return np.flatnonzero(~on_mesh[self.target.used])

    @property
    def on_curves(self) -> NDArray[np.bool_]:
        """Which points lie on the boundary or a crease, (k,)."""
        on = np.zeros(len(self.points), np.bool_)
        on[self.boundary] = True
        on[self.crease] = True
        return on

    @property
    def surface_rows(self) -> NDArray[np.bool_]:
        """Which points pull at the surface, (k,): those on no curve, and those at the ragged boundary of a cloud."""
        inside = ~self.on_curves
        if self.target.cloud:
            inside[self.boundary] = True
        return inside


def _mean_spacing(target: Target, most: float) -> float:
    if not target.is_mesh:
        return 0.0
    corners = target.points[target.triangles]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    return float(np.minimum(length, most).mean())


def _known(rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Each once; without -1, which stands for what is no data, such as the middle of a hole that was closed."""
    return np.unique(rows[rows >= 0])

"""A control mesh: connectivity and positions."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh.data import MeshData, positions
from subdfit.mesh.topology import Topology


@dataclass(frozen=True, eq=False)
class ControlMesh:
    """Control points over a topology.

    Attributes
    ----------
    topology : the connectivity, shared by meshes that differ in positions only.
    points : (n, 3) float64, in the caller's unit.
    scheme : the subdivision scheme it is meant for, or None.
    """

    topology: Topology
    points: NDArray[np.float64]
    scheme: str | None = None

    def __post_init__(self) -> None:
        points = positions(self.points)
        if points.shape != (self.topology.vertex_count, 3):
            raise InputError(f"{points.shape} positions for {self.topology.vertex_count} vertices; give one row each")
        object.__setattr__(self, "points", points)

    @classmethod
    def from_data(cls, data: MeshData) -> "ControlMesh":
        """Build from what a reader gives; raises InputError where that is no oriented manifold."""
        topology = Topology.from_faces(
            data.face_offsets,
            data.face_vertices,
            len(data.points),
            data.crease_edges,
            data.crease_sharpness,
            data.corner_vertices,
            data.corner_sharpness,
        )
        return cls(topology, data.points, data.scheme)

    @classmethod
    def from_triangles(cls, points: ArrayLike, triangles: ArrayLike, **tags: ArrayLike | None) -> "ControlMesh":
        """Build from (n, 3) positions and (m, 3) triangles; `tags` as in `Topology.from_faces`."""
        rows = positions(points)
        return cls(Topology.from_triangles(triangles, len(rows), **tags), rows)

    def with_points(self, points: ArrayLike) -> "ControlMesh":
        """Return the same connectivity with other positions."""
        return ControlMesh(self.topology, positions(points), self.scheme)

    def to_data(self) -> MeshData:
        """Return plain arrays, as writers take them."""
        t = self.topology
        corners = np.flatnonzero(t.corner_sharpness > 0)
        return MeshData(
            points=self.points,
            face_offsets=t.face_offsets.astype(np.int64),
            face_vertices=t.face_vertices.astype(np.int64),
            crease_edges=t.ends(t.crease_edges).astype(np.int64),
            crease_sharpness=t.sharpness[t.crease_edges],
            corner_vertices=corners,
            corner_sharpness=t.corner_sharpness[corners],
            scheme=self.scheme,
            interpolate_boundary=2,
        )

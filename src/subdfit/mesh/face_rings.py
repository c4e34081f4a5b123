"""The faces of a control mesh as rings of vertices, open to edits."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

Ring = list[int]
Edge = frozenset[int]


@dataclass
class FaceRings:
    """Faces as rings of vertices, counter-clockwise, positions of vertices, and how sharp edges inside are."""

    rings: list[Ring]
    points: list[NDArray[np.float64]]
    creases: dict[Edge, float]

    @classmethod
    def of(cls, mesh: ControlMesh) -> Self:
        """The faces of a control mesh."""
        offsets, corners = mesh.topology.face_offsets.tolist(), mesh.topology.face_vertices.tolist()
        rings = [corners[a:b] for a, b in pairwise(offsets)]
        sharp = mesh.topology.crease_edges
        ends = map(frozenset, mesh.topology.ends(sharp).tolist())
        return cls(rings, list(mesh.points), dict(zip(ends, mesh.topology.sharpness[sharp], strict=True)))

    def frozen(self, mesh: ControlMesh) -> ControlMesh:
        """A control mesh of these faces, with their creases and the corners of the mesh that they come from.

        Vertices without a face are left out.
        """
        used, rows = np.unique(np.concatenate(self.rings), return_inverse=True)
        sharpness = np.zeros(len(self.points))
        sharpness[: len(mesh.points)] = mesh.topology.corner_sharpness
        corners = np.flatnonzero(sharpness[used] > 0)
        offsets = np.concatenate([[0], np.cumsum([len(ring) for ring in self.rings])])
        ends = np.array([sorted(edge) for edge in self.creases], np.int64).reshape(-1, 2)
        topology = Topology.from_faces(
            offsets,
            rows,
            len(used),
            crease_edges=np.searchsorted(used, ends),
            crease_sharpness=list(self.creases.values()),
            corner_vertices=corners,
            corner_sharpness=sharpness[used][corners],
        )
        return ControlMesh(topology, np.array(self.points)[used], mesh.scheme)

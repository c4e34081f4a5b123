"""Which part of a surface a change of its control mesh has altered: the rest keeps its footpoints."""

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.places import Places
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.topology import Topology

Flags = NDArray[np.bool_]


def faces_at(topology: Topology, vertices: Flags) -> Flags:
    """Faces, (f,), with a corner among the flagged vertices."""
    return np.logical_or.reduceat(vertices[topology.face_vertices], topology.face_offsets[:-1])


def ring(topology: Topology, vertices: Flags) -> Flags:
    """The flagged vertices and those that share a face with one, (n,)."""
    found = vertices.copy()
    found[topology.face_vertices[faces_at(topology, vertices)[topology.face]]] = True
    return found


def cells_moved_by(surface: LimitSurface, vertices: Flags) -> Flags:
    """Cells, (c,), that the flagged control vertices may move: those of faces that share a corner with a face of one.

    No scheme's masks reach farther than the faces round a vertex.
    """
    faces = faces_at(surface.topology, ring(surface.topology, vertices))
    return np.asarray(faces[Places(surface).face])


def changed_cells(before: LimitSurface, after: LimitSurface) -> Flags:
    """Cells of `after`, (c,), that are not known to lie where the cells of these rows lay `before`."""
    old, new = before.topology, after.topology
    kept = min(old.vertex_count, new.vertex_count)
    moved = np.ones(new.vertex_count, np.bool_)
    moved[:kept] = np.any(before.control_mesh.points[:kept] != after.control_mesh.points[:kept], axis=1)
    if old is not new:
        if after.domain.parts or not (
            np.all(np.diff(old.face_offsets) == 3) and np.all(np.diff(new.face_offsets) == 3)
        ):
            return np.ones(after.domain.face_count, np.bool_)
        moved[:kept] |= old.corner_sharpness[:kept] != new.corner_sharpness[:kept]
        moved[new.triangles[_altered(old, new)]] = True
    return cells_moved_by(after, moved)


def _altered(old: Topology, new: Topology) -> Flags:
    """Triangles of `new`, (m,), that are new, or have other corners or sides of another sharpness than in `old`."""
    kept = min(old.face_count, new.face_count)
    altered = np.ones(new.face_count, np.bool_)
    altered[:kept] = np.any(old.triangles[:kept] != new.triangles[:kept], axis=1)
    sharpness = [t.sharpness[t.edge].reshape(-1, 3)[:kept] for t in (old, new)]
    altered[:kept] |= np.any(sharpness[0] != sharpness[1], axis=1)
    return altered

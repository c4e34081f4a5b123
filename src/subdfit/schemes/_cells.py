"""Parametric faces of schemes whose cells are faces."""

import numpy as np

from subdfit.mesh.topology import Topology
from subdfit.schemes.domain import QUAD, TRIANGLE, Domain


def face_cells(t: Topology, control_vertices: int | None = None) -> Domain:
    """One cell a face of a mesh of triangles and quads, its corners in the face's order.

    Parameters
    ----------
    t
        The mesh; edges that are sharp for ever bound what is smooth.
    control_vertices
        How many of its vertices, the first, are control vertices, its faces being parts of theirs in the order of
        half-edges; None counts all.
    """
    size = np.diff(t.face_offsets)
    cell, side = t.face, (np.arange(len(t.twin)) - t.face_offsets[t.face]).astype(np.int8)
    count = t.vertex_count if control_vertices is None else control_vertices
    neighbour = np.full((t.face_count, 4), -1, np.int32)
    neighbour_side = np.zeros((t.face_count, 4), np.int8)
    sharp = np.zeros((t.face_count, 4), np.bool_)
    vertex = np.full((t.face_count, 4), -1, np.int32)
    inner = t.twin >= 0
    neighbour[cell, side] = np.where(inner, cell[t.twin], -1)
    neighbour_side[cell, side] = np.where(inner, side[t.twin], 0)
    sharp[cell, side] = np.isinf(t.sharpness[t.edge])
    vertex[cell, side] = np.where(t.face_vertices < count, t.face_vertices, -1)
    shape = np.where(size == 3, TRIANGLE, QUAD).astype(np.int8)
    parts = control_vertices is not None
    half_edge = np.arange(t.face_count, dtype=np.int32) if parts else t.face_offsets[:-1]
    return Domain(shape, neighbour, neighbour_side, sharp, vertex, half_edge, parts)

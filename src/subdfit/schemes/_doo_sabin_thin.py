"""Inner vertices of two faces, which Doo-Sabin subdivision would make a polygon of two corners of."""

import numpy as np
import scipy.sparse as sp

from subdfit.mesh._topology_kernels import pair_half_edges
from subdfit.mesh.topology import Creases, Topology


def without_thin_vertices(t: Topology) -> tuple[Topology, sp.csr_array | None]:
    """Cut the faces round inner vertices of two faces into triangles at their centroids.

    Returns
    -------
    topology : the mesh; the centroids are its last vertices.
    matrix : (vertices, n), its vertices from the mesh's; None if there is nothing to cut.
    """
    thin = t.valence == 2
    sharp = np.flatnonzero((t.sharpness > 0)[t.edge])
    thin[t.face_vertices[sharp]] = thin[t.face_vertices[t.following[sharp]]] = False
    if not thin.any():
        return t, None
    cut = np.zeros(t.face_count, np.bool_)
    cut[t.face[thin[t.face_vertices]]] = True
    sides = np.diff(t.face_offsets)
    faces = np.flatnonzero(cut)
    centroid = np.full(t.face_count, -1, np.int32)
    centroid[faces] = t.vertex_count + np.arange(len(faces))
    # Of a face that is cut each half-edge becomes three, a triangle's.
    parts = np.where(cut[t.face], 3, 1)
    place = np.cumsum(parts) - parts
    corners = np.empty(int(parts.sum()), np.int32)
    corners[place] = t.face_vertices
    first = np.flatnonzero(cut[t.face])
    corners[place[first] + 1] = t.face_vertices[t.following[first]]
    corners[place[first] + 2] = centroid[t.face[first]]
    lengths = np.repeat(np.where(cut, 3, sides), np.where(cut, sides, 1))
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)
    count = t.vertex_count + len(faces)
    twin, *_ = pair_half_edges(offsets, corners, count)
    inside = t.twin >= 0
    creases = Creases.of(place[inside], t.sharpness[t.edge[inside]])
    whole = Topology.from_twins(offsets, corners, twin, count, creases)
    whole.corner_sharpness[: t.vertex_count] = t.corner_sharpness
    rows = centroid[t.face[first]] - t.vertex_count
    means = sp.csr_array((1 / sides[t.face[first]], (rows, t.face_vertices[first])), shape=(len(faces), t.vertex_count))
    return whole, sp.csr_array(sp.vstack([sp.eye_array(t.vertex_count), means], format="csr"))

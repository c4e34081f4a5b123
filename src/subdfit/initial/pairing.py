"""Quads from triangles: neighbours are joined in pairs; vertices, boundary, creases and corners stay what they are."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from subdfit.initial import _pairing_kernels as kernels
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]

LEAST_FACES = 3
"""An inner vertex keeps so many faces; one on the boundary keeps one."""
REGULAR_TRIANGLES = 6
VALENCE_WEIGHT = 0.05
"""What one triangle too many at an end of a side counts for joining across it, against a quality of 0 to 1."""


def pair_triangles(mesh: ControlMesh) -> ControlMesh:
    """Join neighbouring triangles to quads.

    A pair is the better the nearer its angles are to right ones (Remacle et al., Blossom-Quad, 2012), the flatter it
    is, so that quads do not lie across ridges, and the more triangles meet at the ends of the side that goes. Where
    pairs leave triangles alone, they change partners. None has an angle of 0 or 180 degrees or a fold of 90.

    Parameters
    ----------
    mesh
        A triangle mesh; its creases are never crossed.

    Returns
    -------
    ControlMesh
        Of quads and the triangles left, over the same vertices. Inner vertices keep three faces or more.
    """
    t = mesh.topology
    quality = pair_quality(mesh.points, t)
    allowed = quality > 0
    surplus = (t.valence - REGULAR_TRIANGLES)[t.face_vertices] + (t.valence - REGULAR_TRIANGLES)[_ends(t)]
    order = np.argsort(-(quality + VALENCE_WEIGHT * surplus), kind="stable")
    order = order[allowed[order] & (order < t.twin[order])].astype(np.int32)
    least = np.where(t.boundary_vertices, 1, LEAST_FACES).astype(np.int32)
    faces_at, mate = t.valence.copy(), np.full(t.face_count, -1, np.int32)
    kernels.match_greedily(order, t.face_vertices, t.twin, least, faces_at, mate)
    kernels.lengthen_matching(allowed, t.face_vertices, t.twin, least, faces_at, mate)
    return _joined(mesh, mate)


def pair_quality(points: Floats, t: Topology) -> Floats:
    """Quality of the quad across each half-edge of a triangle mesh, (h,); 0 across creases and the boundary."""
    corners = points[t.triangles]
    ahead, behind = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    normal = np.cross(ahead[:, 0], ahead[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    cross = np.linalg.norm(np.cross(ahead, behind), axis=2)
    angle = np.arctan2(cross, np.einsum("fsd,fsd->fs", ahead, behind)).ravel()
    quality = np.zeros(len(t.twin))
    here = np.flatnonzero((t.twin >= 0) & (t.sharpness[t.edge] == 0))
    there = t.twin[here]
    start = angle[here] + angle[t.following[there]]
    end = angle[t.following[here]] + angle[there]
    across = np.stack([start, end, angle[_previous(here)], angle[_previous(there)]])
    skew = np.abs(across - np.pi / 2).max(axis=0)
    flatness = np.einsum("kd,kd->k", normal[here // 3], normal[there // 3])
    quality[here] = np.maximum(1 - 2 / np.pi * skew, 0) * np.maximum(flatness, 0)
    return quality


def _previous(half_edge: NDArray[np.integer]) -> NDArray[np.integer]:
    return np.where(half_edge % 3 == 0, half_edge + 2, half_edge - 1)


def _ends(t: Topology) -> NDArray[np.int32]:
    return np.asarray(t.face_vertices[t.following])


def _joined(mesh: ControlMesh, mate: NDArray[np.int32]) -> ControlMesh:
    """Quads where triangles have mates, in the order of the first of each pair."""
    t = mesh.topology
    other = np.where(mate < 0, -1, t.twin[mate] // 3)
    kept = np.flatnonzero((mate < 0) | (np.arange(t.face_count) < other))
    quad = mate[kept] >= 0
    rows = np.full((len(kept), 4), -1, np.int32)
    rows[~quad, :3] = t.triangles[kept[~quad]]
    h = mate[kept[quad]]
    g = t.twin[h]
    # From the far end of the common side on, so that the quad begins with an old side of the first triangle.
    for column, half_edge in enumerate((t.following[h], _previous(h), t.following[g], _previous(g))):
        rows[quad, column] = t.face_vertices[half_edge]
    offsets = np.concatenate([[0], np.cumsum(np.where(quad, 4, 3))])
    data = mesh.to_data()
    joined = replace(data, face_offsets=offsets.astype(np.int64), face_vertices=rows[rows >= 0].astype(np.int64))
    return ControlMesh.from_data(joined)

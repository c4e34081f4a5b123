"""Walks round vertices and faces for Doo-Sabin subdivision."""

import numpy as np

from subdfit.compiled import kernel
from subdfit.mesh._topology_kernels import before


@kernel
def vertex_polygons(  # type: ignore[no-untyped-def]
    begins, face_offsets, face, twin, face_vertices, sharp, at, origin, target, corner, sizes, vertices, place
):
    """Make the polygons of the new vertices round each vertex, or between two of its sharp edges; return their corners.

    Parameters
    ----------
    begins : (k,), the first half-edge of each sector that has one.
    face_offsets, face, twin, face_vertices, sharp, origin, target, corner : the mesh, `Curves` and `Numbers`.
    at : `Numbers.of_face_corner`.
    sizes : (k,), is written: corners of each polygon.
    vertices : the new vertices round each, counter-clockwise, likewise.
    place : (h,), where among them the new vertex of each face corner is; comes as -1, which remains if in none.
    """
    used = 0
    for polygon in range(len(begins)):
        h, begin = begins[polygon], used
        if sharp[h]:
            if corner[face_vertices[h]] >= 0:
                vertices[used] = corner[face_vertices[h]]
                used += 1
            vertices[used] = origin[h]
            used += 1
        g = h
        while True:
            vertices[used] = at[g]
            place[g] = used
            used += 1
            last = before(g, face_offsets, face)
            g = twin[last]
            if sharp[last] or g == h:
                break
        # Where a crease ends inside the surface, the sector ends with the edge with which it began.
        if sharp[h] and twin[last] != h:
            vertices[used] = target[last]
            used += 1
        sizes[polygon] = used - begin
    return used


@kernel
def edge_quads(following, twin, sharp, at, place, first_polygon, corners, twins):  # type: ignore[no-untyped-def]
    """Make the quads of smooth edges, which follow the faces, and pair their sides.

    Two sides of a quad border on the faces, whose half-edges keep their numbers; the others on the polygons of
    vertices, `place` in which is that of `vertex_polygons`, and which begin at half-edge `first_polygon`. `corners` and
    `twins`, the refined mesh's, are written.
    """
    side = len(twin)
    for h in range(len(twin)):
        other = twin[h]
        if other < h or sharp[h]:
            continue
        ahead, behind = following[h], following[other]
        corners[side], corners[side + 1], corners[side + 2], corners[side + 3] = at[ahead], at[h], at[behind], at[other]
        twins[side], twins[h] = h, side
        twins[side + 2], twins[other] = other, side + 2
        for own, beside in ((side + 1, place[behind]), (side + 3, place[ahead])):
            if beside >= 0:
                twins[own], twins[first_polygon + beside] = first_polygon + beside, own
        side += 4


@kernel
def add_face_points(faces, start, face_offsets, face_vertices, mask, inner, target, points, out):  # type: ignore[no-untyped-def]
    """Add the new points of faces that share a mask to rows of `out`.

    Parameters
    ----------
    faces : (k,), of as many corners as the mask (m, m).
    start : (f,) the half-edge with which the mask begins in each face.
    inner : rows of the mask that are wanted.
    target : (h,), the row of `out` (n, 3) for each face corner.
    points : (vertices, 3).
    """
    m = len(mask)
    corners = np.empty((m, 3))
    for f in faces:
        begin = face_offsets[f]
        first = start[f] - begin
        for i in range(m):
            v = face_vertices[begin + (first + i) % m]
            corners[i, 0], corners[i, 1], corners[i, 2] = points[v, 0], points[v, 1], points[v, 2]
        for j in inner:
            x = y = z = 0.0
            for i in range(m):
                w = mask[j, i]
                x, y, z = x + w * corners[i, 0], y + w * corners[i, 1], z + w * corners[i, 2]
            row = target[begin + (first + j) % m]
            out[row, 0] += x
            out[row, 1] += y
            out[row, 2] += z

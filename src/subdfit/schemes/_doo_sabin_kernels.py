"""Walks round vertices and faces for Doo-Sabin subdivision."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def vertex_polygons(face_vertices, twin, preceding, sharp, plain, sector, sector_size, at, origin, target, corner):  # type: ignore[no-untyped-def]
    """Polygons of the new vertices round each vertex, or between two of its sharp edges unless these are plain.

    Parameters are the mesh, `Curves` and `Numbers` arrays of the same names (`at` is `of_face_corner`).

    Returns
    -------
    sizes : int32, corners of each polygon, in the order of the sectors' first half-edges.
    vertices : int32, the new vertices round each, counter-clockwise.
    place : int32 (h,), where among them the new vertex of each face corner is, -1 if in none.
    """
    count = 0
    for h in range(len(face_vertices)):
        if sector[h] == h and not plain[h]:
            count += 1
    sizes = np.empty(count, np.int32)
    vertices = np.empty(len(face_vertices) + 3 * count, np.int32)
    place = np.full(len(face_vertices), -1, np.int32)
    polygon = used = 0
    for h in range(len(face_vertices)):
        if sector[h] != h or plain[h]:
            continue
        begin = used
        if sharp[h]:
            if corner[face_vertices[h]] >= 0:
                vertices[used] = corner[face_vertices[h]]
                used += 1
            vertices[used] = origin[h]
            used += 1
        g, last = h, h
        for _ in range(sector_size[h]):
            vertices[used] = at[g]
            place[g] = used
            used += 1
            last = preceding[g]
            g = twin[last]
        # Where a crease ends inside the surface, the sector ends with the edge with which it began.
        if sharp[h] and twin[last] != h:
            vertices[used] = target[last]
            used += 1
        sizes[polygon] = used - begin
        polygon += 1
    return sizes, vertices[:used].copy(), place


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

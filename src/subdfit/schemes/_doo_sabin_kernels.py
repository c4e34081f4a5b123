"""Walks round vertices for Doo-Sabin subdivision."""

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
    """
    count = 0
    for h in range(len(face_vertices)):
        if sector[h] == h and not plain[h]:
            count += 1
    sizes = np.empty(count, np.int32)
    vertices = np.empty(len(face_vertices) + 3 * count, np.int32)
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
            used += 1
            last = preceding[g]
            g = twin[last]
        if sharp[h]:
            vertices[used] = target[last]
            used += 1
        sizes[polygon] = used - begin
        polygon += 1
    return sizes, vertices[:used].copy()

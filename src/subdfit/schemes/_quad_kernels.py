"""Bicubic patches over quads: the points that each lists."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel


@inlined_kernel
def mirror_point(place, centre, reflected, offset, mirrors, mirror_corners, used):  # type: ignore[no-untyped-def]
    """Row of the point ``2 centre - reflected``, which stands beyond a sharp edge; `place` tells it from others."""
    if mirrors[place] < 0:
        mirrors[place] = used[0]
        mirror_corners[used[0], 0] = centre
        mirror_corners[used[0], 1] = centre
        mirror_corners[used[0], 2] = reflected
        used[0] += 1
    return offset + mirrors[place]


@inlined_kernel
def regular_ring(  # type: ignore[no-untyped-def]
    h,
    out,
    at,
    offsets,
    face_vertices,
    following,
    preceding,
    twin,
    first,
    faces,
    position,
    mirrors,
    mirror_corners,
    used,
):
    """Write the eight neighbours of a regular vertex, counter-clockwise, from the end of its half-edge `h`.

    Beyond sharp edges stand mirror points, with which the smooth rules reproduce those of boundaries and creases.
    `offsets` holds the row offsets of this level's vertices and of its mirror points.
    """
    vertices, offset = offsets[0], offsets[1]
    turn = 2 * (4 - position[h])
    begin = first[h]
    g = begin
    last = begin
    for i in range(faces[h]):
        out[at + (2 * i + turn) % 8] = vertices + face_vertices[following[g]]
        out[at + (2 * i + 1 + turn) % 8] = vertices + face_vertices[following[following[g]]]
        last = preceding[g]
        g = twin[last]
    if faces[h] == 2:
        out[at + (4 + turn) % 8] = vertices + face_vertices[last]
        middle = preceding[begin]
        out[at + (5 + turn) % 8] = mirror_point(
            2 * last, face_vertices[last], face_vertices[preceding[last]], offset, mirrors, mirror_corners, used
        )
        out[at + (6 + turn) % 8] = mirror_point(
            2 * begin, face_vertices[begin], face_vertices[middle], offset, mirrors, mirror_corners, used
        )
        beyond = following[begin]
        out[at + (7 + turn) % 8] = mirror_point(
            2 * begin + 1,
            face_vertices[beyond],
            face_vertices[following[beyond]],
            offset,
            mirrors,
            mirror_corners,
            used,
        )


@kernel
def patch_points(  # type: ignore[no-untyped-def]
    half_edges,
    start,
    offsets,
    face_vertices,
    following,
    preceding,
    twin,
    sharp_count,
    first,
    faces,
    position,
    mirrors,
    mirror_corners,
    used,
):
    """Write the points of patches over quads, each given by the half-edge that leaves its first corner V.

    The order is: V; its ring, edge neighbours and opposite corners of faces by turns, counter-clockwise, from the
    sector's beginning (from the face itself where the sector is closed and smooth); then seven outer points. With a, o,
    b the other corners: three beyond a (from V's side), two beyond o, two beyond b.
    """
    out = np.empty(start[len(half_edges)], np.int32)
    ring = np.empty(8, np.int32)
    for k in range(len(half_edges)):
        h = half_edges[k]
        at = start[k]
        out[at] = offsets[0] + face_vertices[h]
        at += 1
        crease = sharp_count[face_vertices[h]] > 1
        if crease and start[k + 1] - start[k] == 16:
            regular_ring(
                h,
                out,
                at,
                offsets,
                face_vertices,
                following,
                preceding,
                twin,
                first,
                faces,
                position,
                mirrors,
                mirror_corners,
                used,
            )
            at += 8
        else:
            g = h if sharp_count[face_vertices[h]] == 0 else first[h]
            for _ in range(faces[h]):
                out[at] = offsets[0] + face_vertices[following[g]]
                out[at + 1] = offsets[0] + face_vertices[following[following[g]]]
                at += 2
                last = preceding[g]
                g = twin[last]
            if crease:
                out[at] = offsets[0] + face_vertices[last]
                at += 1
        for corner in range(3):
            h = following[h]
            regular_ring(
                h,
                ring,
                0,
                offsets,
                face_vertices,
                following,
                preceding,
                twin,
                first,
                faces,
                position,
                mirrors,
                mirror_corners,
                used,
            )
            if corner == 0:
                out[at], out[at + 1], out[at + 2] = ring[5], ring[6], ring[7]
            elif corner == 1:
                out[at + 3], out[at + 4] = ring[5], ring[6]
            else:
                out[at + 5], out[at + 6] = ring[4], ring[5]
    return out

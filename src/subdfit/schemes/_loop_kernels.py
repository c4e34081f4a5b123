"""Loop subdivision over arrays: the points that each patch lists."""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel
from subdfit.mesh._ring_kernels import following, preceding


@inlined_kernel
def mirror_point(h, offset, face_vertices, mirrors, mirror_corners, used):  # type: ignore[no-untyped-def]
    """Row of the point beyond sharp half-edge `h`, mirrored from its own face: origin + end - apex."""
    if mirrors[h] < 0:
        mirrors[h] = used[0]
        mirror_corners[used[0], 0] = face_vertices[h]
        mirror_corners[used[0], 1] = face_vertices[following(h)]
        mirror_corners[used[0], 2] = face_vertices[preceding(h)]
        used[0] += 1
    return offset + mirrors[h]


@inlined_kernel
def regular_ring(h, out, sizes, at, face_vertices, twin, first, faces, position, mirrors, mirror_corners, used):  # type: ignore[no-untyped-def]
    """Write the six neighbours of a regular vertex, counter-clockwise, from the end of its half-edge `h`.

    Beyond sharp edges stand mirror points: with them Loop's smooth rules reproduce its boundary and crease rules.
    `sizes` holds the row offsets of this level's vertices and of its mirror points.
    """
    vertices, offset = sizes[0], sizes[1]
    turn = 6 - position[h]
    last = h
    for i in range(faces[h]):
        g = twin[last] if i else first[h]
        out[at + (i + turn) % 6] = vertices + face_vertices[following(g)]
        last = preceding(g)
    if faces[h] == 3:
        out[at + (3 + turn) % 6] = vertices + face_vertices[last]
        out[at + (4 + turn) % 6] = mirror_point(last, offset, face_vertices, mirrors, mirror_corners, used)
        out[at + (5 + turn) % 6] = mirror_point(
            np.int64(first[h]), offset, face_vertices, mirrors, mirror_corners, used
        )


@kernel
def patch_points(  # type: ignore[no-untyped-def]
    chosen,
    corner,
    start,
    sizes,
    face_vertices,
    twin,
    sharp_count,
    first,
    faces,
    position,
    mirrors,
    mirror_corners,
    used,
):
    """Write the points of each chosen face's patch.

    The order is: the corner vertex V; its ring, counter-clockwise, from the sector's beginning (from the face itself
    where the sector is closed and smooth); then five outer points. With a, b the other two corners: the vertex o beyond
    edge ab, the two outer neighbours of a (from o to V's side), the two of b (from o to V's side).
    """
    out = np.empty(start[len(chosen)], np.int32)
    ring = np.empty(6, np.int32)
    for k in range(len(chosen)):
        h = 3 * chosen[k] + corner[k]
        at = start[k]
        out[at] = sizes[0] + face_vertices[h]
        at += 1
        smooth = sharp_count[face_vertices[h]] == 0
        if start[k + 1] - start[k] == 12 and faces[h] == 3:
            regular_ring(h, out, sizes, at, face_vertices, twin, first, faces, position, mirrors, mirror_corners, used)
            at += 6
        else:
            g = h if smooth else first[h]
            for i in range(faces[h]):
                out[at] = sizes[0] + face_vertices[following(g)]
                at += 1
                last = preceding(g)
                if i + 1 < faces[h]:
                    g = twin[last]
            if sharp_count[face_vertices[h]] > 1:
                out[at] = sizes[0] + face_vertices[preceding(g)]
                at += 1
        # Round a from b: V, then V's other side, a2, a1, o.
        regular_ring(
            following(h), ring, sizes, 0, face_vertices, twin, first, faces, position, mirrors, mirror_corners, used
        )
        out[at] = ring[5]
        out[at + 1] = ring[4]
        out[at + 2] = ring[3]
        # Round b from V: a, o, b1, b2, V's other side.
        regular_ring(
            preceding(h), ring, sizes, 0, face_vertices, twin, first, faces, position, mirrors, mirror_corners, used
        )
        out[at + 3] = ring[3]
        out[at + 4] = ring[4]
    return out

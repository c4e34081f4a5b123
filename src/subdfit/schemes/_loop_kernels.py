"""Loop subdivision over arrays: sectors, refinement rules and the points that each patch lists."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def before(h):  # type: ignore[no-untyped-def]
    """Half-edge before `h` in its triangle."""
    return h + 2 if h % 3 == 0 else h - 1


@kernel
def after(h):  # type: ignore[no-untyped-def]
    """Half-edge after `h` in its triangle."""
    return h - 2 if h % 3 == 2 else h + 1


@kernel
def sector(h, twin, sharp):  # type: ignore[no-untyped-def]
    """Faces round the origin of `h` between sharp edges.

    Returns
    -------
    first : outgoing half-edge where the sector begins (`h` itself if no edge bounds it).
    faces : number of faces in it.
    position : how many faces lie between its beginning and the face of `h`.
    closed : whether it goes all the way round (at most one sharp edge, which is then where it begins).
    """
    first, position, closed = h, 0, False
    while not sharp[first]:
        first = after(twin[first])
        position += 1
        if first == h:
            position, closed = 0, True
            break
    faces, last = 1, before(first)
    while not sharp[last] and twin[last] != first:
        last = before(twin[last])
        faces += 1
    if not closed and twin[last] >= 0 and twin[last] == first:
        closed = True
    return first, faces, position, closed


@kernel
def child_faces(face_vertices, edge, vertex_count):  # type: ignore[no-untyped-def]
    """Vertices of the four children of each triangle: one at each corner, then the middle one."""
    count = len(face_vertices) // 3
    children = np.empty((4 * count, 3), np.int32)
    for f in range(count):
        a, b, c = face_vertices[3 * f], face_vertices[3 * f + 1], face_vertices[3 * f + 2]
        ab, bc, ca = (
            vertex_count + edge[3 * f],
            vertex_count + edge[3 * f + 1],
            vertex_count + edge[3 * f + 2],
        )
        children[4 * f, 0], children[4 * f, 1], children[4 * f, 2] = a, ab, ca
        children[4 * f + 1, 0], children[4 * f + 1, 1], children[4 * f + 1, 2] = ab, b, bc
        children[4 * f + 2, 0], children[4 * f + 2, 1], children[4 * f + 2, 2] = ca, bc, c
        children[4 * f + 3, 0], children[4 * f + 3, 1], children[4 * f + 3, 2] = bc, ca, ab
    return children


@kernel
def corner_sectors(face_vertices, twin, sharp, sharp_count, pinned):  # type: ignore[no-untyped-def]
    """Describe the sector at every face corner.

    Returns
    -------
    first : int32 (h,), outgoing half-edge where the sector begins.
    faces, position : int32 (h,).
    regular : bool (h,): six smooth faces all round, or three between two sharp edges, and not a corner.
    """
    count = len(face_vertices)
    first = np.empty(count, np.int32)
    faces = np.empty(count, np.int32)
    position = np.empty(count, np.int32)
    regular = np.empty(count, np.bool_)
    for h in range(count):
        v = face_vertices[h]
        first[h], faces[h], position[h], _ = sector(h, twin, sharp)
        smooth = sharp_count[v] == 0 and faces[h] == 6
        crease = sharp_count[v] == 2 and faces[h] == 3
        regular[h] = (smooth or crease) and not pinned[v]
    return first, faces, position, regular


@kernel
def mirror_point(h, offset, face_vertices, mirrors, mirror_corners, used):  # type: ignore[no-untyped-def]
    """Row of the point beyond sharp half-edge `h`, mirrored from its own face: origin + end - apex."""
    if mirrors[h] < 0:
        mirrors[h] = used[0]
        mirror_corners[used[0], 0] = face_vertices[h]
        mirror_corners[used[0], 1] = face_vertices[after(h)]
        mirror_corners[used[0], 2] = face_vertices[before(h)]
        used[0] += 1
    return offset + mirrors[h]


@kernel
def regular_ring(h, out, sizes, at, face_vertices, twin, sharp, mirrors, mirror_corners, used):  # type: ignore[no-untyped-def]
    """Write the six neighbours of a regular vertex, counter-clockwise, from the end of its half-edge `h`.

    Beyond sharp edges stand mirror points: with them Loop's smooth rules reproduce its boundary and crease rules.
    `sizes` holds the row offsets of this level's vertices and of its mirror points.
    """
    first, faces, position, _ = sector(h, twin, sharp)
    vertices, offset = sizes[0], sizes[1]
    g = first
    for i in range(faces):
        out[at + (i - position) % 6] = vertices + face_vertices[after(g)]
        last = before(g)
        if i + 1 < faces:
            g = twin[last]
    if faces == 3:
        last = before(g)
        out[at + (3 - position) % 6] = vertices + face_vertices[last]
        out[at + (4 - position) % 6] = mirror_point(last, offset, face_vertices, mirrors, mirror_corners, used)
        out[at + (5 - position) % 6] = mirror_point(first, offset, face_vertices, mirrors, mirror_corners, used)


@kernel
def patch_points(  # type: ignore[no-untyped-def]
    chosen,
    corner,
    start,
    sizes,
    face_vertices,
    twin,
    sharp,
    sharp_count,
    first,
    faces,
    mirrors,
    mirror_corners,
    used,
):
    """Write the points of each chosen face's patch.

    The order is: the corner vertex V; its ring, counter-clockwise, from the sector's beginning (from the face itself
    where the sector is closed and smooth); then five outer points. With a, b the other two corners: the vertex o beyond
    edge ab, the two outer neighbours of a (from V's side to o), the two of b (from o to V's side).
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
            regular_ring(h, out, sizes, at, face_vertices, twin, sharp, mirrors, mirror_corners, used)
            at += 6
        else:
            g = h if smooth else first[h]
            for i in range(faces[h]):
                out[at] = sizes[0] + face_vertices[after(g)]
                at += 1
                last = before(g)
                if i + 1 < faces[h]:
                    g = twin[last]
            if sharp_count[face_vertices[h]] > 1:
                out[at] = sizes[0] + face_vertices[before(g)]
                at += 1
        # Round a from b: V, then V's other side, a2, a1, o.
        regular_ring(after(h), ring, sizes, 0, face_vertices, twin, sharp, mirrors, mirror_corners, used)
        out[at] = ring[5]
        out[at + 1] = ring[4]
        out[at + 2] = ring[3]
        # Round b from V: a, o, b1, b2, V's other side.
        regular_ring(before(h), ring, sizes, 0, face_vertices, twin, sharp, mirrors, mirror_corners, used)
        out[at + 3] = ring[3]
        out[at + 4] = ring[4]
    return out

"""Connectivity kernels over arrays."""

import numpy as np

from subdfit.compiled import inner_kernel, kernel


@kernel
def repeated_vertex(face_offsets, face_vertices, vertex_count):  # type: ignore[no-untyped-def]
    """Find the first face that has a vertex twice: (face, vertex), or (-1, -1) if none has."""
    last_face = np.full(vertex_count, -1, np.int32)
    for f in range(len(face_offsets) - 1):
        for h in range(face_offsets[f], face_offsets[f + 1]):
            v = face_vertices[h]
            if last_face[v] == f:
                return f, v
            last_face[v] = f
    return -1, -1


@kernel
def pair_half_edges(face_offsets, face_vertices, vertex_count):  # type: ignore[no-untyped-def]
    """Match opposite half-edges in time linear in the faces.

    Each half-edge is looked up among the earlier ones of the same lower vertex, a handful, and then filed with them.

    Returns
    -------
    twin : int32 (h,), -1 on the boundary.
    origin, target : ends of an edge that has a third face or a second face of the same orientation; -1, -1 if none.
    """
    count = len(face_vertices)
    ends = np.empty(count, np.int32)
    start = np.zeros(vertex_count + 1, np.int32)
    for f in range(len(face_offsets) - 1):
        first, last = face_offsets[f], face_offsets[f + 1] - 1
        for h in range(first, last + 1):
            ends[h] = face_vertices[h + 1 if h < last else first]
            start[min(face_vertices[h], ends[h]) + 1] += 1
    for v in range(vertex_count):
        start[v + 1] += start[v]

    filed = np.empty(count, np.int32)
    stop = start.copy()
    twin = np.full(count, -1, np.int32)
    for h in range(count):
        origin, target = face_vertices[h], ends[h]
        low = min(origin, target)
        for slot in range(start[low], stop[low]):
            other = filed[slot]
            opposite = face_vertices[other] == target and ends[other] == origin
            if opposite and twin[other] < 0:
                twin[h], twin[other] = other, h
            elif opposite or (face_vertices[other] == origin and ends[other] == target):
                return twin, origin, target
        filed[stop[low]] = h
        stop[low] += 1
    return twin, -1, -1


@kernel
def link_half_edges(face_offsets, twin, following, face, edge):  # type: ignore[no-untyped-def]
    """Order half-edges round their faces, and number edges as half-edges first meet them; return how many there are.

    `following`, `face` and `edge` (h,) are written.
    """
    edge_count = 0
    for f in range(len(face_offsets) - 1):
        first, last = face_offsets[f], face_offsets[f + 1] - 1
        for h in range(first, last + 1):
            following[h] = h + 1 if h < last else first
            face[h] = f
            if 0 <= twin[h] < h:
                edge[h] = edge[twin[h]]
            else:
                edge[h] = edge_count
                edge_count += 1
    return edge_count


@inner_kernel
def before(h, face_offsets, face):  # type: ignore[no-untyped-def]
    """Half-edge before `h` in its face."""
    f = face[h]
    return face_offsets[f + 1] - 1 if h == face_offsets[f] else h - 1


@kernel
def outgoing_half_edges(face_vertices, twin, outgoing, valence):  # type: ignore[no-untyped-def]
    """Give each vertex one outgoing half-edge: on the boundary the one without a twin, else the lowest.

    `outgoing` (n,) comes as -1, which it remains for an isolated vertex; `valence` (n,), the number of faces round the
    vertex, as 0.
    """
    for h in range(len(face_vertices)):
        v = face_vertices[h]
        valence[v] += 1
        if outgoing[v] < 0 or (twin[h] < 0 and twin[outgoing[v]] >= 0):
            outgoing[v] = h


@kernel
def separate_fans(face_offsets, face, twin, outgoing, valence):  # type: ignore[no-untyped-def]
    """Find a vertex whose faces form more than one fan; -1 if none do."""
    for v in range(len(outgoing)):
        h = outgoing[v]
        if h < 0:
            continue
        fan = 0
        while True:
            fan += 1
            h = twin[before(h, face_offsets, face)]
            if h < 0 or h == outgoing[v] or fan > valence[v]:
                break
        if fan != valence[v]:
            return v
    return -1


@kernel
def find_edges(pairs, outgoing, face_offsets, face_vertices, following, face, twin, edge):  # type: ignore[no-untyped-def]
    """Edges by their ends, either way round, from a walk round the first end.

    Returns
    -------
    found : int32 (len(pairs),), -1 where no edge joins the two.
    """
    found = np.full(len(pairs), -1, np.int32)
    for k in range(len(pairs)):
        target = pairs[k, 1]
        h = outgoing[pairs[k, 0]]
        if face_vertices[following[h]] == target:
            found[k] = edge[h]
        while found[k] < 0:
            last = before(h, face_offsets, face)
            if face_vertices[last] == target:
                found[k] = edge[last]
            h = twin[last]
            if h < 0 or h == outgoing[pairs[k, 0]]:
                break
    return found

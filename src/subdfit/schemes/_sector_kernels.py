"""Sectors: the faces round a vertex between sharp edges, which is all that the surface in them depends on."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def corner_sectors(face_offsets, face_vertices, following, preceding, face, twin, sharp, sharp_count, pinned):  # type: ignore[no-untyped-def]
    """Describe the sector at every face corner: the faces round its vertex between sharp edges, counter-clockwise.

    Returns
    -------
    first : int32 (h,), outgoing half-edge where the sector begins: at a sharp edge, or anywhere if there is none.
    faces, position : int32 (h,), faces in the sector, and how many lie before this one.
    regular : bool (h,): faces of one shape, triangles or quads, that fill the plane (six, four) or half of it between
        two sharp edges (three, two), and not a corner.
    """
    count = len(face_vertices)
    first = np.full(count, -1, np.int32)
    faces = np.empty(count, np.int32)
    position = np.empty(count, np.int32)
    regular = np.empty(count, np.bool_)
    for h in range(count):
        if first[h] >= 0:
            continue
        begin = h
        while not sharp[begin]:
            begin = following[twin[begin]]
            if begin == h:
                break
        shape = face_offsets[face[h] + 1] - face_offsets[face[h]]
        g, size, alike = begin, 0, shape <= 4
        while True:
            first[g] = begin
            position[g] = size
            size += 1
            alike = alike and face_offsets[face[g] + 1] - face_offsets[face[g]] == shape
            last = preceding[g]
            g = twin[last]
            if sharp[last] or g == begin:
                break
        v = face_vertices[h]
        half = 3 if shape == 3 else 2
        smooth = sharp_count[v] == 0 and size == 2 * half
        crease = sharp_count[v] == 2 and size == half
        g = begin
        for _ in range(size):
            faces[g] = size
            regular[g] = alike and (smooth or crease) and not pinned[v]
            g = twin[preceding[g]]
    return first, faces, position, regular


@kernel
def cut_faces(chosen, face_offsets, face_vertices, following, preceding, face, twin, outgoing, vertex_count):  # type: ignore[no-untyped-def]
    """Cut out the chosen faces with two rings of faces round them, as a mesh of their own.

    Vertices at which the cut leaves separate fans of faces are repeated, one for each fan.

    Returns
    -------
    faces : int32 (f,), the faces of the piece, the chosen ones first in their order.
    corners, twins : int32 (h,), its face vertices and twins; vertices : int32 (n,), which vertex each of its was.
    half_edges : int32 (h,), which half-edge each of its was.
    """
    row = np.full(len(face_offsets) - 1, -1, np.int32)
    faces = np.empty(len(row), np.int32)
    used = 0
    for f in chosen:
        row[f] = used
        faces[used] = f
        used += 1
    begin = 0
    for _ in range(2):
        end = used
        for k in range(begin, end):
            f = faces[k]
            for h in range(face_offsets[f], face_offsets[f + 1]):
                start = outgoing[face_vertices[h]]
                g = start
                while True:
                    if row[face[g]] < 0:
                        row[face[g]] = used
                        faces[used] = face[g]
                        used += 1
                    g = twin[preceding[g]]
                    if g < 0 or g == start:
                        break
        begin = end
    faces = faces[:used].copy()
    offset = np.zeros(used + 1, np.int32)
    for k in range(used):
        offset[k + 1] = offset[k] + face_offsets[faces[k] + 1] - face_offsets[faces[k]]
    half_edges = np.empty(offset[used], np.int32)
    place = np.full(len(face_vertices), -1, np.int32)
    for k in range(used):
        for i in range(offset[k + 1] - offset[k]):
            half_edges[offset[k] + i] = face_offsets[faces[k]] + i
            place[face_offsets[faces[k]] + i] = offset[k] + i
    twins = np.full(len(half_edges), -1, np.int32)
    for h in range(len(half_edges)):
        if twin[half_edges[h]] >= 0:
            twins[h] = place[twin[half_edges[h]]]
    corners = np.full(len(half_edges), -1, np.int32)
    vertices = np.empty(len(half_edges), np.int32)
    found = 0
    for h in range(len(half_edges)):
        if corners[h] >= 0:
            continue
        g = half_edges[h]
        first = g
        # Back to where the fan begins, then forwards through all of it.
        while twin[g] >= 0 and place[twin[g]] >= 0:
            g = following[twin[g]]
            if g == first:
                break
        start = g
        while True:
            corners[place[g]] = found
            back = twin[preceding[g]]
            if back < 0 or place[back] < 0 or back == start:
                break
            g = back
        vertices[found] = face_vertices[half_edges[h]]
        found += 1
    return faces, corners, twins, vertices[:found].copy(), half_edges

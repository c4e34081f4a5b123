"""The split of triangles in four and of other faces in quads."""

from subdfit.compiled import inlined_kernel, kernel


@inlined_kernel
def last_side(h, face_offsets, face, least):  # type: ignore[no-untyped-def]
    """The half-edge of the child at the origin of half-edge `h` that ends there, see `split_faces`."""
    begin = face_offsets[face[h]]
    if face_offsets[face[h] + 1] - begin >= least:
        return 4 * h + 3
    corner = h - begin
    return 4 * begin + 3 * corner + (corner + 2) % 3


@kernel
def split_faces(  # type: ignore[no-untyped-def]
    face_offsets, face_vertices, following, face, twin, edge, vertex_count, edge_count, least, offsets, corners, twins
):
    """Cut every face as `subdfit.schemes._split.split` documents.

    The new vertex of edge e is `vertex_count` + e; the centroids of faces with `least` corners or more follow. The
    children's `offsets`, `corners` and `twins`, which come as -1, are written.
    """
    count = len(face_offsets) - 1
    offsets[0] = 0
    child, centroid = 0, vertex_count + edge_count
    for f in range(count):
        begin, end = face_offsets[f], face_offsets[f + 1]
        quads = end - begin >= least
        for _ in range(end - begin if quads else 4):
            offsets[child + 1] = offsets[child] + (4 if quads else 3)
            child += 1
        for h in range(begin, end):
            corner, before = h - begin, h - 1 if h > begin else end - 1
            if not quads:
                middle = 4 * begin + 9
                second = 4 * begin + 3 * corner + (corner + 1) % 3
                # The middle child's side that faces the child at h begins where that child ends.
                inner = middle + (corner + 1) % 3
                corners[inner] = vertex_count + edge[before]
            else:
                second, inner = 4 * h + 1, 4 * following[h] + 2
                corners[4 * h + 2] = centroid
            last = last_side(h, face_offsets, face, least)
            corners[4 * h], corners[second] = face_vertices[h], vertex_count + edge[h]
            corners[last] = vertex_count + edge[before]
            twins[second], twins[inner] = inner, second
            if twin[h] >= 0:
                beyond = last_side(following[twin[h]], face_offsets, face, least)
                twins[4 * h], twins[beyond] = beyond, 4 * h
        centroid += quads

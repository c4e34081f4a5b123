"""Kinds of vertices, and the fewest shapes that have them all."""

import numpy as np

from shapes.zoo import mesh_of

MANY = 8
"""Faces round a vertex from which on there is one kind."""


def kinds(topology):
    """What a mesh has: every pair of a vertex's role with its number of faces, and with the sizes of its faces.

    Closed meshes whose vertices are all of one kind are a kind of their own: there limit operators may be singular.
    """
    t, n = topology, topology.vertex_count
    corners = np.diff(t.face_offsets)
    size = np.minimum(np.repeat(corners, corners), 5)
    smallest, largest = np.full(n, 5), np.zeros(n, int)
    np.minimum.at(smallest, t.face_vertices, size)
    np.maximum.at(largest, t.face_vertices, size)
    faces = np.minimum(np.bincount(t.face_vertices, minlength=n), MANY)
    vertices = list(zip(roles(t), faces.tolist(), smallest.tolist(), largest.tolist(), strict=True))
    found = {(role, count) for role, count, *_ in vertices} | {(role, low, high) for role, _, low, high in vertices}
    alike = len(set(vertices)) == 1 and not t.boundary_edges.any()
    return found | {("everywhere", *vertices[0])} if alike else found


def roles(topology):
    """Smooth, boundary, crease, and so on: by sharp edges and tags, and whether any of them is semi-sharp."""
    t = topology
    sharp, boundary = edges_at(t, t.sharpness > 0), edges_at(t, t.boundary_edges)
    fading = (edges_at(t, np.isfinite(t.sharpness) & (t.sharpness > 0)) > 0) | (
        np.isfinite(t.corner_sharpness) & (t.corner_sharpness > 0)
    )
    names = np.array(["smooth", "dart", "crease", "meeting"])[np.minimum(sharp, 3)].tolist()
    for vertex in range(t.vertex_count):
        if boundary[vertex]:
            names[vertex] = "boundary" if sharp[vertex] == 2 else "end"
        if t.corner_sharpness[vertex] > 0:
            names[vertex] = "corner"
        if fading[vertex]:
            names[vertex] = "semi-sharp " + names[vertex]
    return names


def edges_at(topology, chosen):
    """How many of the chosen edges each vertex has."""
    return np.bincount(topology.edge_vertices[chosen].ravel(), minlength=topology.vertex_count)


def cover(names):
    """Few of the shapes that have every kind together: again and again the one with the most kinds not seen yet."""
    of = {name: kinds(mesh_of(name).topology) for name in names}
    left, chosen = set().union(*of.values()), []
    while left:
        chosen.append(max(names, key=lambda name: len(of[name] & left)))
        left -= of[chosen[-1]]
    return chosen

"""Edges of a triangle mesh, the angles across them, and which of them are creases."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from subdfit.target.normals import face_normals

_WEAK = 25.0
"""Degrees from which an edge may belong to an automatic crease."""
_STRONG = 40.0
"""Degrees that half of the length of an automatic crease reaches."""
_TURN = 50.0
"""Degrees by which an automatic crease may turn at a vertex."""
_CONTRAST = 10.0
"""How many times the mean angle of the smooth edges beside it an automatic crease bends."""
_STRAYS = 0.2
"""Share of the length of the edges beside an automatic crease that may reach the weak angle and belong to no crease."""
_FEWEST = 8
"""Edges of the smallest network of automatic creases, such as those round a coarse bore."""
_ROUNDING = 1e-9
"""Share of a path's length by which a sum of lengths may be off its half."""

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Edges:
    """The edges of a triangle mesh, in increasing order of their vertices.

    Attributes
    ----------
    vertices : (e, 2) int64, the lower first.
    faces : (e, 2) int64, the first two triangles beside the edge; -1 where there is none.
    valence : (e,) int64, how many triangles share the edge: 1 on the boundary, 2 inside.
    angle : (e,) float64, degrees between the normals of the two triangles; 0 unless `valence` is 2.
    of_face : (m, 3) int64, the edges from corner 0 to 1, 1 to 2 and 2 to 0 of each triangle.
    """

    vertices: NDArray[np.int64]
    faces: NDArray[np.int64]
    valence: NDArray[np.int64]
    angle: NDArray[np.float64]
    of_face: NDArray[np.int64]


def mesh_edges(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> Edges:
    """Find the edges of a triangle mesh and the angles across them.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.
    """
    triangles = np.asarray(triangles, np.int64)
    ends = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    key = ends[:, 0] * len(points) + ends[:, 1]
    order = np.argsort(key, kind="stable")
    begins = np.diff(key[order], prepend=-1) != 0
    first = np.flatnonzero(begins)
    valence = np.diff(first, append=len(key))
    of_face = np.empty(len(key), np.int64)
    of_face[order] = np.cumsum(begins) - 1
    faces = np.full((len(first), 2), -1, np.int64)
    faces[:, 0] = order[first] // 3
    shared = valence > 1
    faces[shared, 1] = order[first[shared] + 1] // 3
    angle = np.zeros(len(first))
    inner = valence == 2
    angle[inner] = _angles(face_normals(points, triangles)[faces[inner]])
    return Edges(ends[order[first]], faces, valence, angle, of_face.reshape(-1, 3))


def edges_among(edges: NDArray[np.integer], some: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which edges, (e, 2) vertices in either order, are among some others, (e,)."""
    key = np.array([max(int(edges.max(initial=0)), int(some.max(initial=0))) + 1, 1])
    return np.isin(np.sort(edges, axis=1) @ key, np.sort(some, axis=1) @ key)


def sharp_share(points: NDArray[np.float64], triangles: NDArray[np.integer], creases: NDArray[np.integer]) -> float:
    """How much of a mesh's bending its creases take, 0 to 1: of the angles across edges times their lengths.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.
    creases : (c, 2) int, edges of the mesh.
    """
    edges = mesh_edges(points, triangles)
    bending = edges.angle * np.linalg.norm(np.diff(points[edges.vertices], axis=1)[:, 0], axis=1)
    total = float(bending.sum())
    return float(bending[edges_among(edges.vertices, creases)].sum()) / total if total > 0 else 0.0


def along_edges(
    points: NDArray[np.float64], triangles: NDArray[np.integer], wanted: NDArray[np.integer]
) -> NDArray[np.int64]:
    """Edges of a mesh, (k, 2) int64, that lead from end to end of wanted ones, (w, 2): these, or the shortest way.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`.
    wanted : rows of `points`, such as edges of the same mesh with some of its triangles' sides flipped.
    """
    edges = mesh_edges(points, triangles).vertices
    there = edges_among(wanted, edges)
    if there.all():
        return np.asarray(wanted, np.int64)
    found = [np.sort(wanted[there], axis=1).astype(np.int64)]
    lengths = np.linalg.norm(np.diff(points[edges], axis=1)[:, 0], axis=1)
    graph = coo_array((lengths, (edges[:, 0], edges[:, 1])), shape=(len(points), len(points))).tocsr()
    for start, end in wanted[~there]:
        _, before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)
        way = [int(end)]
        while before[way[-1]] >= 0:
            way.append(int(before[way[-1]]))
        found.append(np.sort(np.column_stack([way[:-1], way[1:]]), axis=1).reshape(-1, 2))
    return np.unique(np.concatenate(found), axis=0)


def _angles(pairs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Degrees between the two vectors of each pair (k, 2, 3); 0 where one vanishes."""
    a, b = pairs[:, 0], pairs[:, 1]
    angle: NDArray[np.float64] = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
    return np.degrees(angle)


def crease_edges(
    points: NDArray[np.float64], triangles: NDArray[np.integer], angle_degrees: float
) -> NDArray[np.int64]:
    """Edges across which the normal turns by more than an angle, (c, 2) int64; never the boundary.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.
    angle_degrees : the angle, 0 for coplanar triangles.
    """
    edges = mesh_edges(points, triangles)
    return edges.vertices[edges.angle > angle_degrees]


def automatic_creases(points: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """Edges that are surely sharp: few on a machined part are missed, none is found in noise.

    Edges above a weak angle are joined to paths where they continue one another smoothly. A path is a
    crease when the median angle along its length is strong and is many times the mean angle of the smooth
    edges of the triangles along it, since tight curvature bends those too; and when few edges there, by
    length, reach the weak angle without belonging to a crease, as they do in noise. For the latter all
    paths are taken for creases first, and as some drop out they count against their neighbours, until none
    drops out. Of the networks that the rest form, those of a few edges only are dropped as chance.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike.

    Returns
    -------
    (c, 2) int64, rows of `points`.
    """
    edges = mesh_edges(points, triangles)
    lengths = np.linalg.norm(np.diff(points[edges.vertices], axis=1)[:, 0], axis=1)
    weak = np.flatnonzero(edges.angle >= _WEAK)
    if len(weak) == 0:
        return np.empty((0, 2), np.int64)
    path = _smooth_paths(points, edges.vertices[weak])
    sharp = np.ones(len(weak), np.bool_)
    while True:
        left = sharp & _stands_out(edges, lengths, weak, path, weak[sharp])[path]
        if np.array_equal(left, sharp):
            break
        sharp = left
    found = edges.vertices[weak[sharp]]
    _, network = _components(found[:, 0], found[:, 1], len(points))
    size = np.bincount(network[found[:, 0]], minlength=1)
    return found[size[network[found[:, 0]]] >= _FEWEST]


def _smooth_paths(points: NDArray[np.float64], ends: NDArray[np.int64]) -> NDArray[np.int32]:
    """Number the smooth paths that edges (k, 2) form: two follow one another when each turns least into the other."""
    vertex, edge = ends.ravel(), np.repeat(np.arange(len(ends)), 2)
    direction = points[ends[:, ::-1].ravel()] - points[vertex]
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), np.finfo(float).tiny)
    order = np.argsort(vertex, kind="stable")
    vertex, edge, direction = vertex[order], edge[order], direction[order]
    low, degree = np.searchsorted(vertex, vertex), np.bincount(vertex)[vertex]
    one = np.repeat(np.arange(len(vertex)), degree)
    other = np.arange(len(one)) - np.repeat(np.cumsum(degree) - degree - low, degree)
    straight = -np.sum(direction[one] * direction[other], axis=1)
    allowed = (one != other) & (straight > np.cos(np.radians(_TURN)))
    one, other, straight = one[allowed], other[allowed], straight[allowed]
    order = np.lexsort((other, -straight, one))
    one, other = one[order], other[order]
    best = np.full(len(vertex), -1)
    least = np.diff(one, prepend=-1) != 0
    best[one[least]] = other[least]
    mutual = (best >= 0) & (best[best] == np.arange(len(vertex)))
    return _components(edge[mutual], edge[best[mutual]], len(ends))[1]


def _stands_out(
    edges: Edges, lengths: Floats, members: NDArray[np.int64], path: NDArray[np.int32], sharp: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Tell which paths are strong and run through a smooth surface, given all the `sharp` edges."""
    beside = edges.of_face[edges.faces[members]].reshape(len(members), 6)
    smooth = (edges.angle < _WEAK) & (edges.valence == 2)
    stray = edges.angle >= _WEAK
    stray[sharp] = False

    def along(values: Floats) -> Floats:
        """Sum over the sides of the triangles along each path."""
        return np.asarray(np.bincount(path, np.sum(values[beside], axis=1)), float)

    seen = along(smooth.astype(float))
    roughness = np.divide(along(edges.angle * smooth), seen, out=np.full(len(seen), np.inf), where=seen > 0)
    median = _medians(edges.angle[members], lengths[members], path)
    stands_out: NDArray[np.bool_] = (median >= _STRONG) & (median >= _CONTRAST * roughness)
    strays = along(lengths * stray)
    stands_out &= strays <= _STRAYS * (along(lengths * smooth) + strays)
    return stands_out


def _medians(values: Floats, weights: Floats, group: NDArray[np.integer]) -> Floats:
    """The least value of each group, 0..g - 1, that half of its weight does not exceed, (g,)."""
    order = np.lexsort((values, group))
    weight = np.bincount(group, weights)
    begin = np.cumsum(weight) - weight
    below = np.cumsum(weights[order]) - begin[group[order]]
    reached = np.where(below >= (0.5 - _ROUNDING) * weight[group[order]], values[order], np.inf)
    least = np.full(len(weight), np.inf)
    np.minimum.at(least, group[order], reached)
    return least


def _components(one: NDArray[np.integer], other: NDArray[np.integer], size: int) -> tuple[int, NDArray[np.int32]]:
    links = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(size, size))
    return connected_components(links, directed=False)

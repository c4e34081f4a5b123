"""An independent judge of triangle meshes, small shapes, and a reader for the real models."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from shapes import grids


@dataclass(frozen=True)
class Shape:
    """What decimation must not change."""

    components: int
    loops: int
    euler: int


def shape_of(count, triangles):
    """Check that the triangles are a manifold in which all vertices are used; return its topology."""
    assert triangles.dtype == np.int64
    assert triangles.flags.c_contiguous
    assert set(np.unique(triangles)) == set(range(count))
    assert (triangles != np.roll(triangles, 1, axis=1)).all()
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(directed, axis=0)) == len(directed), "two faces run along an edge the same way"
    edges, uses = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    assert uses.max() <= 2
    assert len(np.unique(np.sort(triangles, axis=1), axis=0)) == len(triangles)
    assert _corner_fans(triangles) == count, "a vertex joins separate fans"
    rim = edges[uses == 1]
    rim_vertices, ends = np.unique(rim, return_inverse=True)
    loops = pieces(len(rim_vertices), ends.reshape(-1, 2))
    assert len(rim) == len(rim_vertices)
    return Shape(pieces(count, edges), loops, count - len(edges) + len(triangles))


def pieces(count, edges):
    """Number of connected components of a graph."""
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[0] if count else 0


def _corner_fans(triangles):
    """Join face corners across shared edges; each class is one fan of one vertex."""
    corner = np.arange(triangles.size).reshape(-1, 3)
    rows = []
    for i in range(3):
        j = (i + 1) % 3
        rows.append(np.stack([triangles[:, i], triangles[:, j], corner[:, i], corner[:, j]], axis=1))
    sides = {}
    links = []
    for a, b, at_a, at_b in np.concatenate(rows).tolist():
        if (b, a) in sides:
            other_b, other_a = sides[b, a]
            links += [(at_a, other_a), (at_b, other_b)]
        sides[a, b] = at_a, at_b
    return pieces(triangles.size, np.array(links, np.int64).reshape(-1, 2))


def boundary_edges(triangles):
    directed = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges, uses = np.unique(np.sort(directed, axis=1), axis=0, return_counts=True)
    return edges[uses == 1]


def loop_lengths(triangles):
    """Number of edges of each boundary loop, ascending."""
    rim = boundary_edges(triangles)
    vertices, ends = np.unique(rim, return_inverse=True)
    ends = ends.reshape(-1, 2)
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(vertices),) * 2)
    return np.sort(np.bincount(connected_components(graph, directed=False)[1]))


def chains(points, triangles, creases):
    """The crease graph up to links: how often each pair of ends (as positions) is joined, and free cycles."""
    all_edges = {tuple(sorted(e)) for t in triangles.tolist() for e in (t[:2], t[1:], t[::2])}
    links = {}
    for a, b in creases.tolist():
        assert tuple(sorted((a, b))) in all_edges
        links.setdefault(a, []).append(b)
        links.setdefault(b, []).append(a)
    rim = set(boundary_edges(triangles).ravel().tolist())
    ends = {v for v, others in links.items() if len(others) != 2 or v in rim}
    joined = Counter()
    walked = set()
    for start in sorted(ends):
        for ahead in links[start]:
            before, here = start, ahead
            walked.add(frozenset((before, here)))
            while here not in ends:
                before, here = here, next(v for v in links[here] if v != before)
                walked.add(frozenset((before, here)))
            joined[frozenset((_place(points[start]), _place(points[here])))] += 1
    rest = np.array([e for e in creases.tolist() if frozenset(e) not in walked], np.int64).reshape(-1, 2)
    vertices, rows = np.unique(rest, return_inverse=True)
    return joined, pieces(len(vertices), rows.reshape(-1, 2))


def _place(point):
    return tuple(np.round(point, 5).tolist())


def normals(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def sharp_edges(points, triangles, degrees):
    """Inner edges whose faces meet at more than an angle."""
    unit = normals(points, triangles)
    unit /= np.linalg.norm(unit, axis=1, keepdims=True) + 1e-300
    side = {}
    found = []
    for f, t in enumerate(triangles.tolist()):
        for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])):
            other = side.get((b, a))
            if other is not None and unit[f] @ unit[other] < np.cos(np.radians(degrees)):
                found.append((a, b))
            side[a, b] = f
    return np.array(found, np.int64).reshape(-1, 2)


def read(meshes: Path, name):
    """Points that are used, and triangles, of one of the real models."""
    mesh = meshio.read(meshes / f"{name}.ply")
    triangles = mesh.cells_dict["triangle"].astype(np.int64)
    used, rows = np.unique(triangles, return_inverse=True)
    return mesh.points[used].astype(np.float64), rows.reshape(-1, 3)


def tetrahedron():
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
    return points, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def octahedron():
    points = np.concatenate([np.eye(3), -np.eye(3)])
    triangles = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    return points, np.array(triangles)


def sphere(levels):
    """An octahedron refined and pushed out to the unit sphere."""
    points, triangles = octahedron()
    for _ in range(levels):
        sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, row = np.unique(sides, axis=0, return_inverse=True)
        middle = row.reshape(-1, 3) + len(points)
        points = np.concatenate([points, points[edges].mean(axis=1)])
        a, b, c = triangles.T
        p, q, r = middle.T
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))])
    return points / np.linalg.norm(points, axis=1, keepdims=True), triangles


def sheet(rows, columns, wrap_rows=False, wrap_columns=False):
    """Triangles of a grid, and the parameters of its vertices in [0, 1)."""
    grid = grids.vertices(rows, columns)
    grid = grids.wrapped(grid) if wrap_columns else grid
    grid = grids.wrapped(grid.T).T if wrap_rows else grid
    s, t = np.divmod(np.arange(rows * columns), columns)
    return grids.triangles_of(grid), s / rows, t / columns


def torus(rows, columns):
    triangles, s, t = sheet(rows, columns, True, True)
    u, v = 2 * np.pi * s, 2 * np.pi * t
    radius = 1.0 + 0.4 * np.cos(v)
    return np.stack([radius * np.cos(u), radius * np.sin(u), 0.4 * np.sin(v)], axis=1), triangles


def annulus(rows, columns):
    triangles, s, t = sheet(rows, columns, False, True)
    radius = 1.0 + s
    angle = 2 * np.pi * t
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * s], axis=1), triangles


def square(side):
    triangles, s, t = sheet(side, side)
    return np.stack([s, t, 0 * s], axis=1), triangles


def fan(count):
    """A disc of `count` triangles round one vertex."""
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    i = np.arange(count)
    triangles = np.stack([np.full(count, count), i, (i + 1) % count], axis=1)
    return np.concatenate([rim, [[0, 0, 0.1]]]), triangles


def two_triangles():
    return np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]])

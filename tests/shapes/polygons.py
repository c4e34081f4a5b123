"""Tiny hard control meshes of quads and larger polygons, for schemes that take them: see `shapes.zoo`."""

from functools import partial

import numpy as np

from shapes.zoo import Shape, circle, jittered
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology


def polygons(data, name, **tags):
    points, faces = data
    offsets = np.cumsum([0, *(len(face) for face in faces)])
    topology = Topology.from_faces(offsets, np.concatenate(faces), len(points), **tags)
    return ControlMesh(topology, jittered(points, name))


def prism_data(n):
    bottom, top = circle(n, -0.8), circle(n, 0.8)
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return np.vstack([bottom, top]), [list(range(n))[::-1], list(range(n, 2 * n)), *sides]


def prism(n, **tags):
    """Two n-gons joined by quads; with n = 4 a cube: every vertex has valence three."""
    return polygons(prism_data(n), f"prism {n}", **tags)


def rhombic_data(n):
    """Two poles of valence n and a ring of 2 n vertices of valence three, all faces quads (a trapezohedron)."""
    ring = circle(2 * n)
    ring[:, 2] = 0.25 * (-1.0) ** np.arange(2 * n)
    faces = []
    for i in range(n):
        a, b, c, d = (2 + (2 * i + j) % (2 * n) for j in range(4))
        faces += [[0, a, b, c], [1, d, c, b]]
    return np.vstack([[0, 0, 1.2], [0, 0, -1.2], ring]), faces


def rhombic(n, **tags):
    return polygons(rhombic_data(n), f"rhombic {n}", **tags)


def quad_fan_data(n, close=True):
    """Quads round vertex 0: vertices 1, 3, 5 .. are its neighbours, 2, 4, 6 .. the far corners."""
    count = 2 * n if close else 2 * n + 1
    turn = circle(2 * n) if close else circle(4 * n)[:count]
    turn[1::2] *= 1.4
    faces = [[0, *(1 + (2 * i + j) % count for j in range(3))] for i in range(n)]
    return np.vstack([[0, 0, 0.4], turn]), faces


def quad_fan(n, **tags):
    return polygons(quad_fan_data(n), f"quad fan {n}", **tags)


def half_quad_fan(k, **tags):
    """A boundary vertex with k quads."""
    return polygons(quad_fan_data(k, close=False), f"half quad fan {k}", **tags)


def quad_grid_data(rows, columns):
    i, j = (x.ravel() for x in np.mgrid[:rows, :columns])
    a = i * (columns + 1) + j
    y, x = (v.ravel().astype(float) for v in np.mgrid[: rows + 1, : columns + 1])
    faces = np.stack([a, a + 1, a + columns + 2, a + columns + 1], 1)
    return np.stack([x, y, 0.1 * x * y], 1), faces.tolist()


def quad_disc(**tags):
    """A square of 4 x 4 quads: regular inside, with corners of one quad."""
    return polygons(quad_grid_data(4, 4), "quad disc", **tags)


def quad_torus_data(rows, columns):
    i, j = (x.ravel() for x in np.mgrid[:rows, :columns])
    k, m = (i + 1) % rows, (j + 1) % columns
    faces = np.stack([i * columns + j, i * columns + m, k * columns + m, k * columns + j], 1)
    s, t = 2 * np.pi * i / rows, 2 * np.pi * j / columns
    return np.stack([(3 + np.cos(s)) * np.cos(t), (3 + np.cos(s)) * np.sin(t), np.sin(s)], 1), faces.tolist()


def quad_torus(rows, columns, **tags):
    return polygons(quad_torus_data(rows, columns), f"quad torus {rows} {columns}", **tags)


def extruded_data():
    """A cube with quads inset into its faces again and again: valences from 3 to 7, several on one face."""
    points, faces = prism_data(4)
    points, faces = list(points), [list(face) for face in faces]
    for pick in (1, 0, 3, 2, 1, 4):
        corners = faces.pop(pick)
        middle = np.mean([points[c] for c in corners], axis=0)
        new = list(range(len(points), len(points) + 4))
        points += [middle + 0.45 * (points[c] - middle) + 0.3 * middle for c in corners]
        faces.append(new)
        faces += [[corners[i], corners[(i + 1) % 4], new[(i + 1) % 4], new[i]] for i in range(4)]
    return np.array(points), faces


def extruded(**tags):
    return polygons(extruded_data(), "extruded", **tags)


def hanging():
    """Quads of two sizes, open: where they meet a pentagon holds the smaller ones' vertex."""
    points = [[0, 0], [2, 0], [4, 0], [0, 2], [2, 1], [2, 2], [3, 0], [3, 1], [3, 2], [4, 1], [4, 2], [0, 4], [2, 4]]
    points = np.column_stack([np.array(points, float), 0.1 * np.arange(13) % 0.3])
    faces = [[0, 1, 4, 5, 3], [1, 6, 7, 4], [6, 2, 9, 7], [4, 7, 8, 5], [7, 9, 10, 8], [3, 5, 12, 11]]
    return polygons((points, faces), "hanging")


def house():
    """Triangles, quads and a pentagon, closed."""
    points, faces = prism_data(5)
    apex = len(points)
    points = np.vstack([points, [0, 0, 1.6]])
    faces.pop(1)
    return polygons((points, [*faces, *([5 + i, 5 + (i + 1) % 5, apex] for i in range(5))]), "house")


def single(n):
    return polygons((circle(n), [list(range(n))]), f"single {n}")


def across(first, step, count):
    """A chain of edges over a grid's vertices."""
    chain = first + step * np.arange(count + 1)
    return np.column_stack([chain[:-1], chain[1:]]).tolist()


def tagged(seed):
    """Creases on every fifth edge of a shape of quads, strewn at random, and two corners."""
    mesh = extruded()
    random = np.random.default_rng(seed)
    t = mesh.topology
    edges = t.edge_vertices[random.random(t.edge_count) < 0.2]
    corners = random.choice(t.vertex_count, 2, replace=False)
    return polygons(extruded_data(), f"tagged quads {seed}", crease_edges=edges, corner_vertices=corners)


def semi(seed):
    """Semi-sharp creases and corners, strewn at random over quads."""
    mesh = extruded()
    random = np.random.default_rng(seed)
    t = mesh.topology
    edges = t.edge_vertices[random.random(t.edge_count) < 0.25]
    return polygons(
        extruded_data(),
        f"semi quads {seed}",
        crease_edges=edges,
        crease_sharpness=random.uniform(0.2, 2.4, len(edges)),
        corner_vertices=[0, 9],
        corner_sharpness=[1.5, 0.4],
    )


CHAIN = across(10, 1, 4)

POLYGONS: dict[str, Shape] = {
    **{f"prism {n}": partial(prism, n) for n in (3, 4, 5, 8)},
    **{f"rhombic {n}": partial(rhombic, n) for n in (2, 4, 5, 6, 9)},
    **{f"quad fan {n}": partial(quad_fan, n) for n in (2, 3, 4, 5, 7)},
    **{f"half quad fan {k}": partial(half_quad_fan, k) for k in range(1, 6)},
    "quad torus 3 3": partial(quad_torus, 3, 3),
    "quad torus 4 6": partial(quad_torus, 4, 6),
    "quad disc": quad_disc,
    "extruded": extruded,
    "hanging": hanging,
    "house": house,
    **{f"single {n}": partial(single, n) for n in (4, 6)},
    "quad crease across": partial(quad_disc, crease_edges=CHAIN),
    "quad dart": partial(quad_disc, crease_edges=CHAIN[:2]),
    "quad semi crease": partial(quad_disc, crease_edges=CHAIN, crease_sharpness=[0.5, 1.0, 1.7, 2.0]),
    "quad pinned": partial(quad_disc, corner_vertices=[0, 2, 12]),
    **{f"quad dart {n}": partial(rhombic, n, crease_edges=[[0, 2]]) for n in (2, 3, 4, 6)},
    **{
        f"quad parted {n} {k}": partial(rhombic, n, crease_edges=[[0, 2], [0, 2 + 2 * k]])
        for n, k in [(4, 1), (4, 2), (6, 2)]
    },
    "quad star": partial(rhombic, 5, crease_edges=[[0, 2], [0, 4], [0, 8]]),
    "prism crease": partial(prism, 5, crease_edges=[[5 + i, 5 + (i + 1) % 5] for i in range(5)]),
    "prism darts": partial(prism, 5, crease_edges=[[0, 5]]),
    "prism semi": partial(prism, 4, crease_edges=[[0, 1], [1, 2], [2, 6]], crease_sharpness=[2.2, 0.6, 1.0]),
    **{f"tagged quads {seed}": partial(tagged, seed) for seed in range(2)},
    **{f"semi quads {seed}": partial(semi, seed) for seed in range(2)},
}

"""A zoo of tiny hard control meshes: every kind of vertex that a scheme must know, in a few faces each.

``ZOO`` maps names to functions without arguments. Positions are general: symmetric shapes are jittered by a seed that
depends on the name alone, so that no error hides behind a symmetry.
"""

import zlib
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from shapes import grids
from subdfit.mesh.control_mesh import ControlMesh

Shape = Callable[[], ControlMesh]

OCTAHEDRON = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]


def jittered(points, name, share=0.08):
    """Move points by a normal deviate of `share` of the shape's radius."""
    points = np.asarray(points, float)
    radius = np.linalg.norm(points - points.mean(axis=0), axis=1).mean()
    return points + share * radius * np.random.default_rng(zlib.crc32(name.encode())).normal(size=points.shape)


def scattered(mesh, seed=0):
    """Return the same connectivity with points strewn at random: no geometry, only linearity, is left."""
    return mesh.with_points(np.random.default_rng(seed).normal(size=mesh.points.shape))


def octahedron_data():
    return np.vstack([[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]), np.array(OCTAHEDRON)


def icosahedron_data():
    g = (1 + 5**0.5) / 2
    points = [[0, s, t * g] for s in (1, -1) for t in (1, -1)]
    points = np.array([np.roll(p, r) for r in range(3) for p in points])
    near = np.linalg.norm(points[:, None] - points, axis=2) < 2.1
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[c, a]:
                    outward = np.dot(np.cross(points[b] - points[a], points[c] - points[a]), points[a]) > 0
                    faces.append([a, b, c] if outward else [a, c, b])
    return points, np.array(faces)


def halved(points, faces):
    """Cut every triangle in four, on the sphere."""
    points = list(np.asarray(points, float) / np.linalg.norm(points, axis=1, keepdims=True))
    middle: dict[tuple[int, int], int] = {}

    def between(a, b):
        key = (min(a, b), max(a, b))
        if key not in middle:
            middle[key] = len(points)
            points.append((points[a] + points[b]) / np.linalg.norm(points[a] + points[b]))
        return middle[key]

    out = []
    for a, b, c in faces:
        ab, bc, ca = between(a, b), between(b, c), between(c, a)
        out += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.array(points), np.array(out)


def circle(n, height=0.0, phase=0.0):
    t = 2 * np.pi * np.arange(n) / n + phase
    return np.stack([np.cos(t), np.sin(t), np.full(n, height)], 1)


def fan_faces(n, close=True):
    """Triangles from vertex 0 to the vertices 1..n round it (or 1..n + 1 when open)."""
    return [[0, 1 + i, 1 + ((i + 1) % n if close else i + 1)] for i in range(n)]


def pyramid_data(n):
    """An apex over an n-gon; the bottom is cut from its first corner."""
    points = np.vstack([[0, 0, 1.0], circle(n, -0.3)])
    return points, np.array(fan_faces(n) + [[1, i + 1, i] for i in range(2, n)])


def euler(topology):
    """Euler's number."""
    return topology.vertex_count - topology.edge_count + topology.face_count


def grid_data(rows, columns, close_rows=False, close_columns=False):
    """Points of a plane grid of quads that are cut alike, and triangles, which may close in either direction."""
    height, width = rows + (not close_rows), columns + (not close_columns)
    y, x = (v.ravel().astype(float) for v in np.mgrid[:height, :width])
    grid = grids.vertices(height, width)
    grid = grids.wrapped(grid) if close_columns else grid
    grid = grids.wrapped(grid.T).T if close_rows else grid
    return np.stack([x, y, 0 * x], 1), grids.triangles_of(grid.T)


def shape(data, name, **tags):
    points, faces = data
    return ControlMesh.from_triangles(jittered(points, name), np.asarray(faces), **tags)


def tetrahedron():
    return shape(pyramid_data(3), "tetrahedron")


def octahedron():
    return shape(octahedron_data(), "octahedron")


def icosahedron():
    return shape(icosahedron_data(), "icosahedron")


def triangle():
    return shape((circle(3), [[0, 1, 2]]), "triangle")


def two_triangles():
    return shape((circle(4), [[0, 1, 2], [0, 2, 3]]), "two triangles")


def pyramid(n):
    return shape(pyramid_data(n), f"pyramid {n}")


def fan(n):
    """An inner vertex of valence n; every rim vertex has two faces."""
    return shape((np.vstack([[0, 0, 0.5], circle(n)]), fan_faces(n)), f"fan {n}")


def half_fan(k):
    """A boundary vertex with k faces."""
    rim = circle(2 * k)[: k + 1] if k > 1 else circle(3)[:2]
    return shape((np.vstack([[0, -0.1, 0.3], rim]), fan_faces(k, close=False)), f"half fan {k}")


def torus(rows, columns, **tags):
    points, faces = grid_data(rows, columns, True, True)
    s, t = 2 * np.pi * points[:, 1] / rows, 2 * np.pi * points[:, 0] / columns
    points = np.stack([(3 + np.cos(s)) * np.cos(t), (3 + np.cos(s)) * np.sin(t), np.sin(s)], 1)
    return shape((points, faces[:, ::-1]), f"torus {rows} {columns}", **tags)


def annulus():
    points, faces = grid_data(2, 5, close_columns=True)
    t, r = 2 * np.pi * points[:, 0] / 5, 2 + points[:, 1]
    return shape((np.stack([r * np.cos(t), r * np.sin(t), 0 * r], 1), faces[:, ::-1]), "annulus")


def disc(**tags):
    """A square of 4 x 4 cells: regular inside, with corners of one and of two faces."""
    points, faces = grid_data(4, 4)
    points[:, 2] = 0.1 * points[:, 0] * points[:, 1]
    return shape((points, faces), "disc", **tags)


def crowded():
    """Vertices put into faces again and again: valences from 3 to 14, several extraordinary corners on every face."""
    points, faces = pyramid_data(3)
    points, faces = list(points), [list(f) for f in faces]
    for pick in (0, 1, 0, 4, 2, 7, 0, 3, 10, 5, 0, 12):
        a, b, c = faces.pop(pick)
        middle = (points[a] + points[b] + points[c]) / 3
        points.append(middle * (1 + 0.3 / np.linalg.norm(middle)))
        new = len(points) - 1
        faces += [[a, b, new], [b, c, new], [c, a, new]]
    return shape((np.array(points), faces), "crowded")


def crease_ring():
    """A sphere with a closed crease round its equator."""
    points, faces = halved(*octahedron_data())
    flat = np.abs(points[:, 2]) < 1e-9
    edges = {tuple(sorted((f[i], f[i - 2]))) for f in faces for i in range(3) if flat[f[i]] and flat[f[i - 2]]}
    return shape((points, faces), "crease ring", crease_edges=sorted(edges))


def dart(n):
    """A crease of one edge between an apex of valence n and a corner of the base: both its ends are darts."""
    return shape(pyramid_data(n), f"dart {n}", crease_edges=[[0, 3]])


def long_dart(n):
    """A crease of two edges over the apex of an n-gon's refined pyramid, ending in a dart of valence n."""
    points, faces = halved(*pyramid_data(n))
    towards = int(np.argmin(np.linalg.norm(points[n + 1 :] - (points[0] + points[1]) / 2, axis=1))) + n + 1
    return shape((points, faces), f"long dart {n}", crease_edges=[[0, towards], [towards, 1]])


def boundary_dart(n):
    """A crease from the boundary (there a corner) to a dart of valence n."""
    return shape((np.vstack([[0, 0, 0.5], circle(n)]), fan_faces(n)), f"boundary dart {n}", crease_edges=[[0, 2]])


def parted(n, k):
    """A crease through the apex of an n-gon's pyramid that leaves k faces on one side and n - k on the other."""
    return shape(pyramid_data(n), f"parted {n} {k}", crease_edges=[[0, 1], [0, 1 + k]])


def star(n, creases):
    """Creases that meet in the apex of an n-gon's pyramid: a corner."""
    return shape(pyramid_data(n), f"star {n}", crease_edges=[[0, c] for c in creases])


def pinned_inside():
    return shape(octahedron_data(), "pinned inside", corner_vertices=[0, 1])


def pinned_regular():
    """A corner of valence six beside regular vertices."""
    return torus(4, 5, corner_vertices=[6])


def pinned_boundary():
    """Corners at a boundary vertex of one face, of two, of three."""
    return disc(corner_vertices=[0, 4, 2])


def pinned_crease():
    return shape(pyramid_data(6), "pinned crease", crease_edges=[[0, 1], [0, 4]], corner_vertices=[0])


def pinned_dart():
    return shape(pyramid_data(6), "pinned dart", crease_edges=[[0, 1]], corner_vertices=[0, 1])


def crease_across():
    """A crease across an open square, from boundary to boundary."""
    return disc(crease_edges=[[10 + i, 11 + i] for i in range(4)])


def tagged_sphere(seed):
    """Creases on every fifth edge of a sphere, strewn at random, and two corners."""
    points, faces = halved(*icosahedron_data())
    mesh = ControlMesh.from_triangles(points, faces)
    random = np.random.default_rng(seed)
    edges = mesh.topology.edge_vertices[random.random(mesh.topology.edge_count) < 0.2]
    return shape((points, faces), f"tagged sphere {seed}", crease_edges=edges, corner_vertices=random.choice(42, 2))


def semi(seed):
    """Semi-sharp creases and corners, strewn at random over a sphere."""
    points, faces = halved(*octahedron_data())
    mesh = ControlMesh.from_triangles(points, faces)
    random = np.random.default_rng(seed)
    edges = mesh.topology.edge_vertices[random.random(mesh.topology.edge_count) < 0.2]
    return shape(
        (points, faces),
        f"semi {seed}",
        crease_edges=edges,
        crease_sharpness=random.uniform(0.2, 2.4, len(edges)),
        corner_vertices=[0, 9],
        corner_sharpness=[1.5, 0.4],
    )


def semi_across():
    """A crease across an open square, of uneven sharpness: where it falls, part of the curve is sharp longer."""
    return disc(crease_edges=[[10 + i, 11 + i] for i in range(4)], crease_sharpness=[0.5, 1.0, 1.7, 2.0])


def two_components():
    points, faces = pyramid_data(4)
    other = np.vstack([[0, 0, 0.5], circle(5)]) + np.array([3, 0, 0])
    return shape((np.vstack([points, other]), [*faces, *(np.array(fan_faces(5)) + len(points))]), "two components")


VALENCES = (*range(3, 13), 25)

ZOO: dict[str, Shape] = {
    "tetrahedron": tetrahedron,
    "octahedron": octahedron,
    "icosahedron": icosahedron,
    "triangle": triangle,
    "two triangles": two_triangles,
    **{f"pyramid {n}": partial(pyramid, n) for n in VALENCES[1:]},
    **{f"fan {n}": partial(fan, n) for n in VALENCES},
    **{f"half fan {k}": partial(half_fan, k) for k in range(1, 9)},
    "torus 3 3": partial(torus, 3, 3),
    "torus 4 7": partial(torus, 4, 7),
    "annulus": annulus,
    "disc": disc,
    "crowded": crowded,
    "crease ring": crease_ring,
    **{f"dart {n}": partial(dart, n) for n in range(3, 10)},
    "long dart 5": partial(long_dart, 5),
    **{f"boundary dart {n}": partial(boundary_dart, n) for n in (3, 6, 8)},
    **{f"parted {n} {k}": partial(parted, n, k) for n, k in [(3, 1), (4, 2), (5, 2), (6, 1), (6, 2), (6, 3), (9, 4)]},
    "star 5": partial(star, 5, (1, 2, 4)),
    "star 6": partial(star, 6, (1, 2, 3, 4, 5, 6)),
    "star 8": partial(star, 8, (1, 4, 7)),
    "pinned inside": pinned_inside,
    "pinned regular": pinned_regular,
    "pinned boundary": pinned_boundary,
    "pinned crease": pinned_crease,
    "pinned dart": pinned_dart,
    "crease across": crease_across,
    **{f"tagged sphere {seed}": partial(tagged_sphere, seed) for seed in range(3)},
    **{f"semi {seed}": partial(semi, seed) for seed in range(2)},
    "semi across": semi_across,
    "two components": two_components,
}


@cache
def shapes() -> dict[str, Shape]:
    """Return the whole zoo: triangles, polygons, and both."""
    from shapes.curved import CURVED
    from shapes.mixed import MIXED
    from shapes.polygons import POLYGONS

    return ZOO | POLYGONS | CURVED | MIXED


@cache
def mesh_of(name: str) -> ControlMesh:
    """Return a shape of the zoo, made once."""
    return shapes()[name]()

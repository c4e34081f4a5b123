"""Control meshes of OpenSubdiv's regression shapes, whose refined positions are in the baseline files.

Coordinates, faces and tags are those of ``regression/shapes/catmark_*.h`` of
https://github.com/PixarAnimationStudios/OpenSubdiv, rebuilt here from what their vertices have in common. A sharpness
of 10 is sharp for ever. "Edge and corner" is tagged as what it means: boundary vertices of a single face are corners.
"""

from itertools import pairwise

import numpy as np

from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology


def cage(points, faces, creases=(), corners=()):
    """A control mesh; creases are (vertex, vertex, sharpness), corners (vertex, sharpness)."""
    creases, corners = np.reshape(list(creases), (-1, 3)), np.reshape(list(corners), (-1, 2))
    topology = Topology.from_faces(
        np.cumsum([0, *map(len, faces)]),
        np.concatenate(faces),
        len(points),
        creases[:, :2].astype(int),
        creases[:, 2],
        corners[:, 0].astype(int),
        corners[:, 1],
    )
    return ControlMesh(topology, np.asarray(points, float), "catmull-clark")


def cube(**tags):
    """A cube turned by 45 degrees about z: vertices two by two, from the top's front round to the bottom's."""
    r = 1.414214
    points = [(0, -r, 1), (r, 0, 1), (-r, 0, 1), (0, r, 1), (-r, 0, -1), (0, r, -1), (0, -r, -1), (r, 0, -1)]
    faces = [[0, 1, 3, 2], [2, 3, 5, 4], [4, 5, 7, 6], [6, 7, 1, 0], [1, 7, 5, 3], [6, 0, 2, 4]]
    return cage(points, faces, **tags)


def pyramid():
    points = [(0, 0, 2), (0, -2, 0), (2, 0, 0), (0, 2, 0), (-2, 0, 0)]
    return cage(points, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [4, 3, 2, 1]])


def chaikin():
    """A bar of five quads a side, its creases sharper from one end to the other: pairs of vertices go round it."""
    x = [1.5, 0.9, 0.3, -0.3, -0.9, -1.5]
    rim = [(a, 0.5) for a in x] + [(a, -0.5) for a in x[::-1]]
    points = [(a, b, z) for a, z in rim for b in (-0.5, 0.5)]
    ring = [2 * i for i in range(12)]
    faces = [[a, a + 1, b + 1, b] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
    for i in range(5):
        faces += [[2 * i + 1, 23 - 2 * i, 21 - 2 * i, 2 * i + 3], [22 - 2 * i, 2 * i, 2 * i + 2, 20 - 2 * i]]
    along = [(i, s) for i, s in enumerate([1, 2, 3, 4, 5, 5, 5, 4, 3, 2, 1, 5])]
    creases = [(2 * i + j, (2 * i + 2) % 24 + j, s) for i, s in along for j in (0, 1)]
    return cage(points, faces, [*creases, *((a, a + 1, 5) for a in (0, 10, 12, 22))])


def grid(cells):
    """Faces of a square grid whose vertices are numbered row by row."""
    width = cells + 1
    return [[a, a + 1, a + width + 1, a + width] for i in range(cells) for a in range(i * width, i * width + cells)]


def tips(cells):
    """The four vertices of a single face in it."""
    return [0, cells, cells * (cells + 1), (cells + 1) ** 2 - 1]


def ridge(cells, step, height, raised, creased):
    """A square on its tip; its third column of vertices is raised in some rows and creased by 2 over some edges."""
    i, j = np.mgrid[: cells + 1, : cells + 1].reshape(2, -1)
    points = np.column_stack([step * (j - i), step * (i + j - cells), height * ((j == 2) & (i < raised))])
    column = [2 + k * (cells + 1) for k in range(creased + 1)]
    return cage(points, grid(cells), [(a, b, 2) for a, b in pairwise(column)], [(tip, 10) for tip in tips(cells)])


AWAY = np.array([-1.25, -0.917, -0.583, -0.25])
NEAR = -AWAY[::-1]
BEND = np.array([0, -0.25, -0.25, 0])


def quarter(x, y, z):
    """Points of a patch, row by row, from x and z of its columns and rows and y by column or by both."""
    rows, columns = len(z), len(x)
    parts = (np.broadcast_to(a, (rows, columns)).ravel() for a in (x, y, np.reshape(z, (-1, 1))))
    return np.column_stack(list(parts))


def quarters(parts, corners):
    """One mesh of several square patches."""
    points, faces = [], []
    for part in parts:
        faces += [[len(points) + v for v in face] for face in grid(int(len(part) ** 0.5) - 1)]
        points += part.tolist()
    return cage(points, faces, (), corners)


def edge_only():
    """Flat, bent with two corners, one quad, one quad with corners of 10 and of 2."""
    single = quarter([-1.25, -0.25], 0, [-1.25, -0.25])
    parts = [quarter(AWAY, 0, NEAR), quarter(NEAR, BEND, NEAR), single, single + np.array([1.5, 0, 0])]
    return quarters(parts, [(16, 10), (19, 10), (36, 10), (37, 10), (38, 2), (39, 2)])


def edge_and_corner():
    """Flat, bent, bent both ways, one quad: all with corners."""
    bowl = np.minimum(BEND, BEND[:, None])
    parts = [quarter(AWAY, 0, NEAR), quarter(NEAR, BEND, NEAR), quarter(AWAY, bowl, AWAY)]
    parts.append(quarter([0.25, 1.25], 0, [-1.25, -0.25]))
    starts = [(0, 3), (16, 3), (32, 3), (48, 1)]
    return quarters(parts, [(start + tip, 10) for start, cells in starts for tip in tips(cells)])


CAGES = {
    "cube": cube(),
    "cube_creases0": cube(creases=[(0, 1, 2), (1, 3, 2)]),
    "pyramid": pyramid(),
    "chaikin0": chaikin(),
    "tent_creases0": ridge(3, 0.565686, 0.8, raised=2, creased=2),
    "dart_edgecorner": ridge(4, 0.5, 1.0, raised=3, creased=2),
    "edgeonly": edge_only(),
    "edgecorner": edge_and_corner(),
}

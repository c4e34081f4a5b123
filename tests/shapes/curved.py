"""Shapes for schemes that treat curves by how the faces beside them meet them (Doo-Sabin): see `shapes.zoo`."""

from functools import partial

import numpy as np

from shapes.polygons import polygons, quad_disc, quad_torus, rhombic
from shapes.zoo import Shape, circle, fan_faces, grid_data, icosahedron_data, jittered, octahedron_data
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES


def dual_data(points, faces):
    """A vertex for each triangle, a polygon for each vertex."""
    faces = np.asarray(faces)
    polygons = []
    for v in range(len(points)):
        ring = {int(f[(np.flatnonzero(f == v)[0] + 1) % 3]): k for k, f in enumerate(faces) if v in f}
        follow = {a: int(faces[k][(np.flatnonzero(faces[k] == v)[0] + 2) % 3]) for a, k in ring.items()}
        at, polygon = next(iter(ring)), []
        for _ in ring:
            polygon.append(ring[at])
            at = follow[at]
        polygons.append(polygon)
    return np.asarray(points)[faces].mean(axis=1), polygons


def open_dodecahedron():
    """A face taken out: pentagons with one edge on a smooth boundary."""
    points, faces = dual_data(*icosahedron_data())
    return polygons((points, faces[1:]), "open dodecahedron")


def open_truncated_octahedron():
    """A square taken out: hexagons with one edge on the boundary."""
    points, faces = dual_data(*hexakis_data())
    gone = next(k for k, face in enumerate(faces) if len(face) == 4)
    return polygons((points, [*faces[:gone], *faces[gone + 1 :]]), "open truncated octahedron")


def hexakis_data():
    """A cube with a pyramid on each face: six vertices of valence four, eight of valence six."""
    points, faces = octahedron_data()
    centres = np.array([points[face].mean(axis=0) for face in faces])
    triangles = []
    for v in range(6):
        after = {
            face[(place + 1) % 3]: (k, face[(place + 2) % 3])
            for k, face in enumerate(faces.tolist())
            for place in range(3)
            if face[place] == v
        }
        triangles += [[v, 6 + k, 6 + after[last][0]] for k, last in after.values()]
    return np.vstack([points, centres]), triangles


def pentagon_corner():
    """An open grid of quads whose first corner has a face of five vertices."""
    mesh = quad_disc()
    t = mesh.topology
    faces = [t.face_vertices[a:b].tolist() for a, b in zip(t.face_offsets[:-1], t.face_offsets[1:], strict=True)]
    corner = next(f for f in faces if 0 in f)
    inner = corner[(corner.index(0) + 2) % 4]
    opposite = next(f for f in faces if inner in f and not set(f) & set(corner) - {inner})
    new = len(mesh.points)
    # The vertex inside parts in two, joined by an edge between the two faces.
    for face in (corner, opposite):
        place = face.index(inner)
        face[place : place + 1] = [inner, new] if face is corner else [new, inner]
    other = corner[(corner.index(new) + 1) % 5]
    for face in faces:
        if face is not corner and face is not opposite and inner in face and other in face:
            face[face.index(inner)] = new
    points = np.vstack([mesh.points, mesh.points[inner] + [0.2, -0.2, 0.1]])
    return polygons((points, faces), "pentagon corner")


def box():
    """A cube of four quads a side, all its edges creases."""
    line = np.arange(3) - 1.0
    points, row, faces = [], {}, []
    for axis in range(3):
        for sign in (-1, 1):
            for i in range(2):
                for j in range(2):
                    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
                    face = []
                    for a, b in square[::sign]:
                        p = np.roll([sign, line[i + a], line[j + b]], axis)
                        if tuple(p) not in row:
                            row[tuple(p)] = len(points)
                            points.append(p)
                        face.append(row[tuple(p)])
                    faces.append(face)
    points = np.array(points)
    edge = (np.abs(points) == 1).sum(axis=1) >= 2
    pairs = {tuple(sorted((f[i], f[i - 1]))) for f in faces for i in range(4) if edge[f[i]] and edge[f[i - 1]]}
    return polygons((points, faces), "box", crease_edges=sorted(pairs))


def fan(n, name, **tags):
    mesh = ControlMesh.from_triangles(np.vstack([[0, 0, 0.5], circle(n)]), fan_faces(n), **tags)
    return mesh.with_points(jittered(mesh.points, name))


def ring_of_quads():
    """Quads between two boundaries."""
    faces = [[i, (i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    return polygons((np.vstack([circle(6), 1.8 * circle(6, 0.3)])[::-1], [f[::-1] for f in faces]), "ring of quads")


def lone_pair():
    """A triangle and a quad, apart from a grid of triangles: every vertex is on the boundary."""
    points, faces = grid_data(2, 2)
    others = np.array([[5, 0, 0], [6, 0, 0], [5.5, 1, 0], [6.5, 1, 0.4], [6.6, 0.3, 0]])
    n = len(points)
    return polygons(
        (np.vstack([points, others]), [*faces.tolist(), [n, n + 1, n + 2], [n + 1, n + 4, n + 3, n + 2]]), "lone pair"
    )


def tip():
    """A crease that ends inside the surface, opposite to a quad, once refined: both its sides are curves already."""
    mesh = rhombic(3, crease_edges=[[0, 2]])
    step = SCHEMES["doo-sabin"].refine(mesh.topology)
    return ControlMesh(step.child, step.refined(mesh.points))


CURVED: dict[str, Shape] = {
    "open dodecahedron": open_dodecahedron,
    "open truncated octahedron": open_truncated_octahedron,
    "pentagon corner": pentagon_corner,
    "box": box,
    "torus crease": partial(quad_torus, 4, 6, crease_edges=[[i, (i + 1) % 6] for i in range(6)]),
    "tagged boundary": partial(quad_disc, corner_vertices=[2]),
    "parted fan": partial(fan, 6, "parted fan", crease_edges=[[0, 1], [0, 4]]),
    "narrow fan": partial(fan, 6, "narrow fan", crease_edges=[[0, 1], [0, 2]]),
    "starred fan": partial(fan, 7, "starred fan", crease_edges=[[0, 1], [0, 3], [0, 6]]),
    "ring of quads": ring_of_quads,
    "lone pair": lone_pair,
    "tip": tip,
}

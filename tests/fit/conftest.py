"""Small targets for fitting."""

import numpy as np
import pytest

from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import scheme_named
from subdfit.target.target import Target, mesh_target


def sphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere from a subdivided icosahedron, vertices on the sphere."""
    from shapes.zoo import icosahedron_data

    points, faces = icosahedron_data()
    mesh = ControlMesh.from_triangles(points, faces)
    for _ in range(levels):
        step = scheme_named("loop").refine(mesh.topology)
        moved = step.matrix @ mesh.points
        mesh = ControlMesh(step.child, moved / np.linalg.norm(moved, axis=1, keepdims=True))
    return mesh.points, mesh.topology.triangles


@pytest.fixture(scope="session")
def ball() -> Target:
    """Unit sphere of 10,242 vertices."""
    points, faces = sphere(5)
    return mesh_target(points, faces, creases="none")


@pytest.fixture(scope="session")
def dome() -> Target:
    """The upper half of a unit sphere: one boundary loop."""
    points, faces = sphere(4)
    keep = np.all(points[faces][:, :, 2] > -0.05, axis=1)
    used = np.unique(faces[keep])
    row = np.full(len(points), -1)
    row[used] = np.arange(len(used))
    return mesh_target(points[used], row[faces[keep]], creases="none")


@pytest.fixture(scope="session")
def petal() -> Target:
    """A bent disk with a smooth waved rim."""
    rings, spokes = 16, 96
    radius, angle = np.repeat(np.arange(1, rings + 1) / rings, spokes), np.tile(np.arange(spokes), rings)
    angle = 2 * np.pi * angle / spokes
    x, y = (radius * (1 + 0.2 * np.cos(3 * angle)) * f(angle) for f in (np.cos, np.sin))
    points = np.concatenate([np.zeros((1, 3)), np.column_stack([x, y, 0.4 * x * y + 0.3 * x**2])])
    here = 1 + np.arange(spokes)
    ahead = np.roll(here, -1)
    fan = np.column_stack([np.zeros(spokes, np.int64), here, ahead])
    band = np.concatenate(
        [np.column_stack([here, here + spokes, ahead + spokes]), np.column_stack([here, ahead + spokes, ahead])]
    )
    bands = [band + spokes * k for k in range(rings - 1)]
    return mesh_target(points, np.concatenate([fan, *bands]), creases="none")


@pytest.fixture(scope="session")
def box() -> Target:
    """A cube's surface with a fine grid on each side: twelve sharp edges."""
    n = 12
    grid = np.linspace(-1, 1, n + 1)
    points, faces = [], []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            base = sum(len(p) for p in points)
            a, b = np.meshgrid(grid, grid, indexing="ij")
            side = np.empty(((n + 1) ** 2, 3))
            side[:, axis] = sign
            side[:, (axis + 1) % 3], side[:, (axis + 2) % 3] = a.ravel(), b.ravel()
            points.append(side)
            i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
            corner = base + (i * (n + 1) + j).ravel()
            quads = np.column_stack([corner, corner + n + 1, corner + n + 2, corner + 1])
            halves = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
            faces.append(halves if sign > 0 else halves[:, ::-1])
    merged, inverse = np.unique(np.round(np.concatenate(points), 12), axis=0, return_inverse=True)
    return mesh_target(merged, inverse.ravel()[np.concatenate(faces)], creases=40.0)

"""A control mesh that uses everything a file can hold."""

import numpy as np
import pytest

from subdfit.mesh.data import MeshData


@pytest.fixture
def house() -> MeshData:
    """Five points, a quad and four triangles; awkward digits, a crease for ever, a soft one, a corner."""
    points = np.array([[0.1, 0, 1 / 3], [1, 0, 1e-17], [1, np.pi, 0], [-0.0, 1e300 ** (1 / 4), 0], [0.5, 0.5, -1e-5]])
    return MeshData(
        points=points,
        face_offsets=np.array([0, 4, 7, 10, 13, 16]),
        face_vertices=np.array([3, 2, 1, 0, 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4]),
        crease_edges=np.array([[0, 1], [2, 4]]),
        crease_sharpness=np.array([np.inf, 2.5]),
        corner_vertices=np.array([4]),
        corner_sharpness=np.array([3.25]),
        scheme="catmull-clark",
        interpolate_boundary=2,
    )


@pytest.fixture
def tetrahedron() -> MeshData:
    """Four triangles with coordinates that float32 holds."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.5]])
    return MeshData(points, np.arange(0, 13, 3), np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3]))

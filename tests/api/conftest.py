"""Small targets for the tests of the library's front."""

import numpy as np
import pytest
import trimesh

from shapes import grids


@pytest.fixture(scope="session")
def sphere() -> tuple[np.ndarray, np.ndarray]:
    """Return a sphere of 642 points and 1,280 triangles."""
    mesh = trimesh.creation.icosphere(3)
    return np.array(mesh.vertices), np.array(mesh.faces)


@pytest.fixture(scope="session")
def sheet() -> tuple[np.ndarray, np.ndarray]:
    """Return an open, wavy sheet of 625 points."""
    n = 25
    x, y = np.meshgrid(np.linspace(0, 2, n), np.linspace(0, 1, n), indexing="ij")
    points = np.stack([x, y, 0.1 * np.sin(3 * x) * np.cos(2 * y)], axis=-1).reshape(-1, 3)
    return points, grids.triangles_of(grids.vertices(n, n))

"""Files for the tests of the command line."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

import subdfit


@pytest.fixture(scope="session")
def sphere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a PLY file of a sphere of 642 points."""
    mesh = trimesh.creation.icosphere(3)
    path = tmp_path_factory.mktemp("targets") / "sphere.ply"
    subdfit.write(path, subdfit.api.mesh_data((np.array(mesh.vertices), np.array(mesh.faces))))
    return path


@pytest.fixture(scope="session")
def cage(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an OBJ file of an octahedron with two creases and a corner."""
    points = np.vstack([np.eye(3), -np.eye(3)])
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    mesh = subdfit.ControlMesh.from_triangles(points, faces, crease_edges=[[0, 1], [1, 3]], corner_vertices=[4])
    path = tmp_path_factory.mktemp("cages") / "cage.obj"
    subdfit.write(path, mesh)
    return path

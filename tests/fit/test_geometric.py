"""The method ``geometric``: its weights, and what accelerates it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import Delaunay

from subdfit.fit.data import FitData
from subdfit.fit.driver import fit_target
from subdfit.fit.geometric import Geometric, influence
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.limit import LimitSurface
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.target import Target, mesh_target


def test_points_pull_at_the_corners_of_their_triangle_by_barycentric_coordinates() -> None:
    mesh = ControlMesh.from_triangles(np.eye(4, 3), [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    rows = influence(LimitSurface(mesh, "loop"), np.array([1, 0], np.int32), np.array([[0.2, 0.3], [0.0, 1.0]]))
    np.testing.assert_allclose(rows.toarray(), [[0.5, 0, 0.2, 0.3], [0, 0, 1, 0]])


@pytest.mark.parametrize("scheme", ["loop", "catmull-clark"])
def test_weights_sum_to_one(scheme: str) -> None:
    from shapes.zoo import icosahedron_data

    mesh = ControlMesh.from_triangles(*icosahedron_data())
    surface = LimitSurface(mesh, scheme)
    count = surface.domain.face_count
    rows = influence(surface, np.arange(count, dtype=np.int32), np.full((count, 2), 0.25))
    assert rows.shape == (count, len(mesh.points))
    np.testing.assert_allclose(rows.sum(axis=1), 1.0)


@pytest.mark.parametrize("faster", [{"over_relaxation": 1.3}, {"nesterov": True}])
def test_accelerated_it_comes_closer_in_as_many_iterations(faster: dict[str, object], dome: Target) -> None:
    few = FitSettings(
        method="geometric", tolerance=Tolerance(max=1e-9), control_vertices=60, max_control_vertices=60,
        max_iterations=5,
    )  # fmt: skip
    plain, quick = fit_target(dome, few), fit_target(dome, replace(few, **faster))  # type: ignore[arg-type]
    assert quick.measurement.rms < plain.measurement.rms


def test_points_that_no_inner_vertex_can_meet_move_the_boundary() -> None:
    """A single triangle has boundary vertices alone, and a bump of the target reaches no others."""
    n = 8
    i, j = np.array([(i, j) for i in range(n + 1) for j in range(n + 1 - i)]).T
    points = np.column_stack([i / n, j / n, np.where((i > 0) & (j > 0) & (i + j < n), 0.1, 0.0)])
    target = mesh_target(points, Delaunay(points[:, :2]).simplices, creases="none")
    mesh = ControlMesh.from_triangles(target.points[[0, n, len(points) - 1]], [[0, 2, 1]])
    state = FitState.start(FitData.of(target, 1.0), LimitSurface(mesh, "loop"))
    moved = Geometric(FitSettings(method="geometric")).displacements(state)
    assert np.all(moved[:, 2] > 0)

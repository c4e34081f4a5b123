"""Thin parts: a surface that mixes their sheets up is noticed, and the fit begins with more control vertices."""

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.fit.data import FitData
from subdfit.fit.sheets import mixed
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.target import mesh_target


@pytest.mark.parametrize("turned", [False, True])
def test_the_share_of_a_ball_inside_out_is_one(turned: bool) -> None:
    ball, coarse = trimesh.creation.icosphere(4), trimesh.creation.icosphere(1)
    faces = np.asarray(coarse.faces)
    mesh = ControlMesh.from_triangles(coarse.vertices, faces[:, ::-1] if turned else faces)
    data = FitData.of(mesh_target(ball.vertices, ball.faces), 1.0)
    assert mixed(FitState.start(data, LimitSurface(mesh, "loop"))).share == pytest.approx(float(turned))


@pytest.mark.parametrize("scheme", ["loop", "doo-sabin"])
def test_a_casting_of_thin_plates_is_certified(meshes, scheme: str) -> None:
    """Its plates are a fiftieth of its diagonal thick, and a start of 5 % of its points turns some inside out."""
    result = subdfit.fit(meshes / "casting.ply", max_error="0.3%", scheme=scheme)
    assert result.certified
    assert result.history[0].control_vertices > 0.05 * 5096


def test_sheets_are_parted_where_they_mix_and_nowhere_else() -> None:
    """A ball that runs out into a plate, three thousandths as thick: its start is not made finer all over."""
    ball = trimesh.creation.icosphere(5)
    points = np.array(ball.vertices)
    thickness = 0.003 + 0.997 / (1 + np.exp(np.clip(12 * points[:, 0], -50, 50)))
    points[:, 2] *= thickness
    points[:, 0] += 3 * np.maximum(points[:, 0], 0)
    result = subdfit.fit((points, ball.faces), max_error="0.1%", creases="none")
    assert result.certified
    assert 1.05 * 512 < result.history[0].control_vertices < 1.5 * 512

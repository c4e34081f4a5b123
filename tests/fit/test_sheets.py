"""Thin parts: a surface that mixes their sheets up is noticed, and the fit begins with more control vertices."""

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.fit.data import FitData
from subdfit.fit.sheets import mixed_share
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
    assert mixed_share(FitState.start(data, LimitSurface(mesh, "loop"))) == pytest.approx(float(turned))


@pytest.mark.parametrize("scheme", ["loop", "doo-sabin"])
def test_a_casting_of_thin_plates_is_certified(meshes, scheme: str) -> None:
    """Its plates are a fiftieth of its diagonal thick, and a start of 5 % of its points turns some inside out."""
    result = subdfit.fit(meshes / "casting.ply", max_error="0.3%", scheme=scheme)
    assert result.certified
    assert result.history[0].control_vertices > 0.05 * 5096

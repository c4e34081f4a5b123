"""Independence of the tessellation, the point of Lavoué et al. 2007: a part meshed badly gets the same control mesh."""

import numpy as np
import pytest

import subdfit
from shapes.drilled import drilled_block
from shapes.parts import can, shaft, with_slivers
from subdfit.initial.decimate import decimate
from subdfit.target.features import automatic_creases

SHAPES = {"can": can(32, 14), "drilled block": drilled_block(0.125), "shaft": shaft(40, 0.15)}


def decimated(points, triangles):
    """A third of the vertices, which leaves long triangles where the surface is flat or ruled."""
    creases = automatic_creases(points, triangles)
    found = decimate(points, triangles, len(points) // 3, crease_edges=creases)
    return found.points, found.triangles


def noisy(points, triangles):
    """Normal noise of .1 % of the diagonal."""
    sigma = 1e-3 * np.linalg.norm(np.ptp(points, axis=0)) / np.sqrt(3)
    return points + sigma * np.random.default_rng(0).normal(size=points.shape), triangles


@pytest.mark.parametrize("name", SHAPES)
def test_bad_meshes_of_a_part_get_control_meshes_as_small_and_as_near(name: str) -> None:
    """Sizes and errors, against the well meshed part, within 20 %."""
    well = SHAPES[name]
    found = []
    for mesh in (well, with_slivers(*well), decimated(*well), noisy(*well)):
        result = subdfit.fit(mesh, scheme="quad-triangle", method="lavoue", max_error="1%")
        assert result.certified
        topology = result.control_mesh.topology
        error = subdfit.measure(result.control_mesh, well).rms
        found.append((topology.vertex_count, topology.face_count, error))
    np.testing.assert_allclose(found[1:], [found[0]] * 3, rtol=0.2)

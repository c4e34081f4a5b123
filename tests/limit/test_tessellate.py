"""The lattice on the surface: welded along sides, apart along nothing, and of the domain's topology."""

import numpy as np
import pytest

from shapes.parameters import size, surface_of
from shapes.zoo import ZOO
from subdfit.errors import InputError
from subdfit.limit.tessellate import lattice
from subdfit.mesh.topology import Topology


@pytest.mark.parametrize("segments", [1, 2, 5])
@pytest.mark.parametrize("name", ZOO)
def test_lattice_has_the_topology_of_the_control_mesh(name, segments):
    surface = surface_of("loop", name)
    t, grid = surface.topology, lattice(surface.domain, segments)
    assert len(grid.triangles) == segments**2 * t.face_count
    fine = Topology.from_triangles(grid.triangles, len(grid.face))
    euler = [x.vertex_count - x.edge_count + x.face_count for x in (t, fine)]
    assert euler[0] == euler[1]
    assert fine.boundary_edges.sum() == segments * t.boundary_edges.sum()
    inner = (segments - 1) * (segments - 2) // 2
    assert len(grid.face) == t.vertex_count + (segments - 1) * t.edge_count + inner * t.face_count


@pytest.mark.parametrize("name", ["crowded", "disc", "tagged sphere 0"])
def test_lattice_triangles_lie_in_their_cell(name):
    """Every triangle's corners are where its own cell puts them, though a neighbour may have lent the vertex."""
    segments = 4
    surface = surface_of("loop", name)
    grid = lattice(surface.domain, segments)
    position = surface.evaluate(grid.face, grid.uv).position
    cell = np.arange(len(grid.triangles)) // segments**2
    steps = np.array([(i, j) for j in range(segments + 1) for i in range(segments + 1 - j)]) / segments
    face = np.repeat(np.arange(surface.domain.face_count), len(steps))
    own = surface.evaluate(face, np.tile(steps, (surface.domain.face_count, 1))).position
    own = own.reshape(-1, len(steps), 3)
    gap = np.linalg.norm(position[grid.triangles][:, :, None] - own[cell][:, None], axis=3).min(axis=2)
    assert gap.max() < 1e-13 * size(surface.control_mesh)


def test_one_segment_is_the_control_mesh():
    surface = surface_of("loop", "crowded")
    grid = lattice(surface.domain, 1)
    position = surface.evaluate(grid.face, grid.uv).position
    np.testing.assert_allclose(position, surface.vertex_limits(), atol=1e-14)
    np.testing.assert_array_equal(grid.triangles, surface.topology.triangles)


def test_refuses_no_segments():
    with pytest.raises(InputError, match="1 or more segments"):
        lattice(surface_of("loop", "triangle").domain, 0)

"""The lattice on the surface: welded along sides, apart along nothing, and of the domain's topology."""

import numpy as np
import pytest

from shapes.parameters import CASES, SOME, size, surface_of
from subdfit.errors import InputError
from subdfit.limit.tessellate import cut, grid_nodes, lattice, manifold_triangles, triangles_at
from subdfit.mesh.topology import Topology
from subdfit.schemes.domain import QUAD, TRIANGLE


@pytest.mark.parametrize("segments", [1, 5])
@pytest.mark.parametrize(("scheme", "name"), CASES)
def test_lattice_has_the_topology_of_the_cells(scheme, name, segments):
    surface = surface_of(scheme, name)
    domain, grid = surface.domain, lattice(surface.domain, segments)
    quads = domain.shape == QUAD
    assert len(grid.triangles) == segments**2 * (np.count_nonzero(~quads) + 2 * np.count_nonzero(quads))
    fine = Topology.from_triangles(manifold_triangles(domain, segments, grid), len(grid.face))
    sides, ends = domain.present.sum(), (domain.present & (domain.neighbour < 0)).sum()
    edges = (sides + ends) // 2
    corners = len(np.unique(domain.points[domain.present]))
    assert fine.boundary_edges.sum() == segments * ends
    n = segments - 1
    inner = n * (n - 1) // 2 * np.count_nonzero(~quads) + n * n * np.count_nonzero(quads)
    assert len(grid.face) == corners + n * edges + inner
    t = surface.topology
    euler = [x.vertex_count - x.edge_count + x.face_count for x in (t, fine)]
    assert euler[0] == euler[1] == corners - edges + domain.face_count


@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_lattice_triangles_lie_in_their_cell(scheme, name):
    """Every triangle's corners are where its own cell puts them, though a neighbour may have lent the vertex."""
    segments = 3
    surface = surface_of(scheme, name)
    domain, grid = surface.domain, lattice(surface.domain, segments)
    position = surface.evaluate(grid.face, grid.uv).position
    for shape in np.unique(domain.shape):
        cells = np.flatnonzero(domain.shape == shape)
        nodes = np.array(grid_nodes(shape, segments)) / segments
        own = surface.evaluate(np.repeat(cells, len(nodes)), np.tile(nodes, (len(cells), 1))).position
        own = own.reshape(len(cells), len(nodes), 3)[:, cut(shape, segments)]
        count = len(cut(shape, segments))
        found = position[grid.triangles[grid.begin[cells][:, None] + np.arange(count)]]
        assert np.abs(own - found).max() < 1e-13 * size(surface.control_mesh)


@pytest.mark.parametrize(("shape", "area"), [(TRIANGLE, 1 / 2), (QUAD, 1.0)])
def test_triangles_keep_the_orientation_of_their_cell_and_fill_it(shape, area):
    corners = (np.array(grid_nodes(shape, 3)) / 3)[cut(shape, 3)]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turned = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    assert (turned > 0).all()
    assert turned.sum() == pytest.approx(area)


@pytest.mark.parametrize("segments", [1, 4])
@pytest.mark.parametrize(("scheme", "name"), SOME)
def test_places_are_found_in_the_triangles_that_hold_them(scheme, name, segments):
    """Middles of triangles in their own, all nodes in one of which they are a corner."""
    domain = surface_of(scheme, name).domain
    begin = lattice(domain, segments).begin
    for cell, shape in enumerate(domain.shape):
        nodes, cuts = grid_nodes(shape, segments), cut(shape, segments)
        places = np.concatenate([nodes[cuts].mean(axis=1), nodes]) / segments
        found = triangles_at(domain, segments, np.full(len(places), cell), places) - begin[cell]
        np.testing.assert_array_equal(found[: len(cuts)], np.arange(len(cuts)))
        assert (cuts[found[len(cuts) :]] == np.arange(len(nodes))[:, None]).any(axis=1).all()


def test_one_segment_is_the_control_mesh():
    surface = surface_of("loop", "crowded")
    grid = lattice(surface.domain, 1)
    position = surface.evaluate(grid.face, grid.uv).position
    np.testing.assert_allclose(position, surface.vertex_limits(), atol=1e-14)
    np.testing.assert_array_equal(grid.triangles, surface.topology.triangles)


def test_refuses_no_segments():
    with pytest.raises(InputError, match="1 or more segments"):
        lattice(surface_of("loop", "triangle").domain, 0)

"""Whole parts: the network of curves along which they are cut, and watertight control meshes over it."""

import numpy as np
import pytest
import trimesh

from shapes import grids
from shapes.drilled import distance_from_edges, drilled_block
from shapes.parts import can
from shapes.zoo import euler
from subdfit.curves.network import fit_network, sharp_vertices
from subdfit.errors import InputError
from subdfit.fit.lavoue_whole import cut_part, whole_start
from subdfit.limit.surface import LimitSurface
from subdfit.target.network import Cuts, curve_network
from subdfit.target.segmentation_cutting import part_cuts, without_handles
from subdfit.target.target import mesh_target, point_target


@pytest.fixture(scope="module")
def drilled():
    return drilled_block(0.125)


def network_of(points, triangles):
    part = cut_part(mesh_target(points, triangles))
    turns = sharp_vertices(points, part.cuts.edges[part.cuts.exact])
    return part, curve_network(part.target.triangles, part.cuts, turns)


def test_points_are_not_cut_into_patches(drilled):
    with pytest.raises(InputError, match="reconstruct"):
        cut_part(point_target(drilled[0]))


def test_a_part_is_cut_along_its_edges_into_its_faces(drilled):
    """Six sides and the bore; twelve straight edges and two round ones, each between two faces."""
    points, triangles = drilled
    part, network = network_of(points, triangles)
    assert len(network.patches) == 7
    assert sorted(arc.closed for arc in network.arcs) == [False] * 12 + [True] * 2
    assert all(arc.sharp and arc.exact for arc in network.arcs)
    np.testing.assert_array_equal(
        np.sort(np.concatenate([patch.faces for patch in network.patches])), np.arange(len(triangles))
    )
    assert all(patch.is_disk_with_holes for patch in network.patches)
    assert sorted(len(patch.loops) for patch in network.patches) == [1, 1, 1, 1, 2, 2, 2]
    sides = np.concatenate([loop.steps[:, 1:] for patch in network.patches for loop in patch.loops])
    np.testing.assert_array_equal(np.sort(2 * sides[:, 0] + sides[:, 1]), np.arange(2 * len(network.arcs)))
    assert len(part.target.crease_edges) == sum(len(arc.vertices) - (not arc.closed) for arc in network.arcs)


def test_loops_run_along_their_arcs(drilled):
    points, triangles = drilled
    _, network = network_of(points, triangles)
    for patch in network.patches:
        for loop in patch.loops:
            ends = [*loop.steps[1:, 0], len(loop.vertices)]
            own = patch.origin[np.append(loop.vertices, loop.vertices[0])]
            for (begin, arc, along), end in zip(loop.steps, ends, strict=True):
                chain = network.arcs[arc].vertices
                chain = np.append(chain, chain[0]) if network.arcs[arc].closed else chain
                np.testing.assert_array_equal(own[begin : end + 1], chain if along else chain[::-1])


def test_arcs_share_their_ends_and_meet_the_tolerance(drilled):
    points, triangles = drilled
    _, network = network_of(points, triangles)
    found = fit_network(points, network.arcs, 0.02)
    np.testing.assert_array_equal(found.points[: len(found.nodes)], points[found.nodes])
    straight = [chain for arc, chain in zip(network.arcs, found.chains, strict=True) if not arc.closed]
    assert all(len(chain) == 2 for chain in straight)
    for arc, chain, places in zip(network.arcs, found.chains, found.places, strict=True):
        assert np.all(np.diff(places) >= 0)
        if not arc.closed:
            np.testing.assert_array_equal(found.nodes[chain[[0, -1]]], arc.vertices[[0, -1]])
        else:
            assert len(chain) >= 4
            assert distance_from_edges(found.limits[chain]).max() < 0.02


def test_the_block_is_joined_watertight_along_its_edges(drilled):
    points, triangles = drilled
    target = mesh_target(points, triangles)
    mesh = whole_start(cut_part(target), 5e-3 * target.diagonal)
    topology = mesh.topology
    assert topology.vertex_count == 16  # eight corners, and four about each end of the bore
    assert euler(topology) == 0
    assert len(topology.edge_vertices[topology.boundary_edges]) == 0
    sharp = topology.edge_vertices[topology.crease_edges]
    limits = LimitSurface(mesh, "quad-triangle").vertex_limits()
    assert distance_from_edges(limits[sharp.ravel()]).max() < 0.02


def test_a_can_is_six_faces():
    """Two lids and a body whose edges follow its axis."""
    points, triangles = can()
    target = mesh_target(points, triangles)
    mesh = whole_start(cut_part(target), 5e-3 * target.diagonal)
    assert mesh.topology.vertex_count == 8
    np.testing.assert_array_equal(np.diff(mesh.topology.face_offsets), [4] * 6)


def test_three_control_points_a_rim_where_these_do():
    points, triangles = can()
    target = mesh_target(points, triangles)
    mesh = whole_start(cut_part(target), 2e-2 * target.diagonal)
    assert mesh.topology.vertex_count == 6
    assert euler(mesh.topology) == 2
    assert not mesh.topology.boundary_edges.any()


@pytest.mark.parametrize(
    ("shape", "number"),
    [(trimesh.creation.icosphere(3), 2), (trimesh.creation.torus(1.0, 0.4, 48, 24), 0)],
    ids=["sphere", "torus"],
)
def test_closed_faces_and_handles_are_cut(shape, number):
    points, triangles = np.asarray(shape.vertices), np.asarray(shape.faces, np.int64)
    none = np.empty((0, 2), np.int64)
    cuts = part_cuts(points, triangles, np.zeros(len(triangles), np.int64), none)
    assert len(cuts.edges) == 0
    cuts = without_handles(points, triangles, cuts)
    patches = curve_network(triangles, cuts).patches
    assert len(patches) > 1
    assert all(patch.is_disk_with_holes for patch in patches)
    assert not cuts.sharp.any()
    target = mesh_target(points, triangles)
    mesh = whole_start(cut_part(target), 0.02 * target.diagonal)
    assert euler(mesh.topology) == number
    assert len(mesh.topology.edge_vertices[mesh.topology.boundary_edges]) == 0
    assert not np.any(mesh.topology.sharpness)


def test_a_crease_that_fades_out_is_led_on():
    """A sheet with a ridge that sinks to nothing on the way: the slit is led to the far side, and parts the sheet."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(21.0), np.arange(21.0), indexing="ij"))
    points = np.column_stack([x, y, -np.abs(y - 10) * np.maximum(1 - x / 16, 0)])
    i = grids.vertices(21, 21)
    triangles = grids.triangles_of(i)
    ridge = np.stack([i[:14, 10], i[1:15, 10]], 1)
    cuts = part_cuts(points, triangles, np.zeros(len(triangles), np.int64), ridge)
    network = curve_network(triangles, cuts)
    assert len(network.patches) == 2
    led = [arc for arc in network.arcs if arc.sharp and not arc.exact]
    assert len(led) == 1
    assert led[0].vertices[[0, -1]].tolist() in ([i[14, 10], i[20, 10]], [i[20, 10], i[14, 10]])


def test_kinds_of_edges_part_arcs():
    """A square of edges, half of them sharp: two arcs, which end where the kinds change."""
    edges = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])
    sharp = np.array([True, True, False, False])
    triangles = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]])
    network = curve_network(triangles, Cuts(edges, sharp, sharp))
    assert [(arc.vertices.tolist(), arc.sharp) for arc in network.arcs] == [([0, 1, 2], True), ([2, 3, 0], False)]
    assert [patch.faces.tolist() for patch in network.patches] == [[0, 1, 2, 3], [4, 5, 6, 7]]

"""Collapses and merges: what is allowed leaves a manifold of the same topology, with the same creases."""

import numpy as np
import pytest

from shapes.curved import CURVED
from shapes.mixed import MIXED
from shapes.polygons import POLYGONS
from shapes.zoo import ZOO, euler, mesh_of
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.polygon_edits import PolygonEdits

SHAPES = sorted({**ZOO, **POLYGONS, **MIXED, **CURVED})


def character(mesh: ControlMesh) -> tuple[int, int, list[int], int]:
    """Euler's number; loops of the boundary; how many sharp edges meet where curves begin, meet or end; corners."""
    t = mesh.topology
    rim = t.edge_vertices[t.boundary_edges]
    sharp = np.bincount(t.edge_vertices[t.sharpness > 0].ravel(), minlength=t.vertex_count)
    ends = sorted(sharp[(sharp > 0) & (sharp != 2)].tolist())
    return euler(t), len(rim) - len(np.unique(rim)), ends, int(np.sum(t.corner_sharpness > 0))


def rings(edits: PolygonEdits) -> list[tuple[int, ...]]:
    """The faces, each from its least vertex on."""
    return sorted((*ring[k:], *ring[:k]) for ring in edits.rings.values() for k in [ring.index(min(ring))])


def pairs(edits: PolygonEdits, count: int) -> list[tuple[int, int]]:
    return [(v, w) for v in range(count) if edits.faces_at(v) for w in sorted(edits.neighbours(v))]


@pytest.mark.parametrize("name", SHAPES)
def test_whatever_is_allowed_keeps_the_topology_and_the_creases(name: str) -> None:
    mesh = mesh_of(name)
    before, edits = character(mesh), PolygonEdits(mesh)
    for _ in range(mesh.topology.edge_count):
        left = pairs(edits, mesh.topology.vertex_count)
        joint = [(v, w) for v, w in left if edits.may_merge(v, w, 5)]
        if joint:
            edits.merge(*joint[len(joint) // 2])
        short = [(v, w) for v, w in pairs(edits, mesh.topology.vertex_count) if edits.may_collapse(v, w)]
        if short:
            edits.collapse(*short[len(short) // 2])
        if not joint and not short:
            break
        lighter, rows = edits.frozen()
        assert character(lighter) == before
        np.testing.assert_array_equal(lighter.points, mesh.points[rows])


@pytest.mark.parametrize("name", SHAPES)
def test_turns_keep_the_topology_and_the_faces_sizes_and_turn_back(name: str) -> None:
    mesh = mesh_of(name)
    sizes, sharp = np.diff(mesh.topology.face_offsets), mesh.topology.edge_vertices[mesh.topology.sharpness > 0]
    edits = PolygonEdits(mesh)
    for forward in (True, False):
        for a, b in pairs(edits, mesh.topology.vertex_count):
            if b not in edits.neighbours(a) or not edits.may_turn(a, b, forward):
                continue
            before = rings(edits)
            u, w = (edits.turned(a, b, forward)[0][k] for k in (0, -1))
            edits.turn(a, b, forward)
            after, _ = edits.frozen()
            assert character(after) == character(mesh)
            assert sorted(np.diff(after.topology.face_offsets)) == sorted(sizes)
            assert w in edits.neighbours(u)
            assert b not in edits.neighbours(a)
            kept = {frozenset(side) for side in after.topology.edge_vertices[after.topology.sharpness > 0].tolist()}
            assert kept == {frozenset(side) for side in sharp.tolist()}
            edits.turn(u, w, not forward)
            assert rings(edits) == before
            edits.turn(a, b, forward)


def test_most_shapes_have_edges_that_may_turn() -> None:
    """So that the test above says something."""
    count = 0
    for name in SHAPES:
        edits, vertices = PolygonEdits(mesh_of(name)), mesh_of(name).topology.vertex_count
        count += any(edits.may_turn(a, b, True) for a, b in pairs(edits, vertices))
    assert count > len(SHAPES) / 2


def test_a_collapse_and_a_merge_in_numbers() -> None:
    """Three by three quads: a corner of the middle one goes to the next, then the edge between two of the faces."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(3), np.arange(3), indexing="ij"))
    quads = np.column_stack([4 * i + j, 4 * (i + 1) + j, 4 * (i + 1) + j + 1, 4 * i + j + 1])
    points = np.column_stack([*np.divmod(np.arange(16), 4), np.zeros(16)]).astype(float)
    edits = PolygonEdits(ControlMesh.from_data(_data(points, quads)))
    assert not edits.may_collapse(1, 5)  # from the boundary inwards
    assert not edits.may_collapse(0, 1) or edits.sharp_neighbours(0) == {1, 4}
    edits.collapse(5, 6)
    mesh, rows = edits.frozen()
    assert 5 not in rows
    assert sorted(np.diff(mesh.topology.face_offsets)) == [3, 3, 4, 4, 4, 4, 4, 4, 4]
    triangles = [ring for ring in edits.rings.values() if len(ring) == 3]
    assert sorted(map(sorted, triangles)) == [[1, 2, 6], [6, 9, 10]]
    assert edits.may_merge(1, 6, 5)
    edits.merge(1, 6)
    assert sorted(len(ring) for ring in edits.rings.values()) == [3, 4, 4, 4, 4, 4, 4, 5]


def _data(points, quads):
    from subdfit.mesh.data import MeshData

    return MeshData(points, np.arange(0, 4 * len(quads) + 1, 4), quads.ravel())

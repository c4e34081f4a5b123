"""Vertices taken out of open surfaces: none that is needed stays out, none that is not stays in."""

import numpy as np
import pytest

from subdfit.fit.lavoue_enrichment import Faces
from subdfit.fit.lavoue_lightening import lightened
from subdfit.fit.lavoue_open import OpenFit
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.curvature import curvature_field
from subdfit.target.target import mesh_target

SCHEMES = ["quad-triangle", "catmull-clark"]


def plate(n, scheme):
    """A square of n x n quads with tagged corners."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)
    corners = i[[0, 0, -1, -1], [0, -1, 0, -1]]
    topology = Topology.from_faces(4 * np.arange(n * n + 1), quads.ravel(), (n + 1) ** 2, corner_vertices=corners)
    return ControlMesh(topology, np.stack([x, y, 0 * x], -1).reshape(-1, 3) / n, scheme)


def fitted(mesh, *, within):
    """A plate that is taken for a fit of a finer one, and that."""
    dense = plate(8, mesh.scheme)
    quads = dense.topology.face_vertices.reshape(-1, 4)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    target, field = mesh_target(dense.points, triangles), curvature_field(dense.points, triangles)
    return OpenFit(mesh, 0.0, 0.0, within, []), target, field, 1e-6


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_plate_keeps_no_vertex_inside(scheme):
    mesh = plate(4, scheme)
    found = lightened(*fitted(mesh, within=True))
    assert found.within
    assert found.mesh.topology.face_count == 1
    rim = np.unique(mesh.topology.edge_vertices[mesh.topology.boundary_edges])
    np.testing.assert_array_equal(found.mesh.points, mesh.points[rim])


def test_one_that_is_not_within_is_returned_as_it_is():
    given = fitted(plate(4, "catmull-clark"), within=False)
    assert lightened(*given) is given[0]


def test_what_taking_out_leaves_with_two_faces_goes_as_well():
    """Of 3 x 3 quads, whose inner vertices are 5, 6, 9 and 10, two taken out leave the other two with two faces."""
    faces = Faces.of(plate(2, "catmull-clark"))
    assert faces.take_out(4)
    assert [sorted(ring) for ring in faces.rings] == [[0, 1, 2, 3, 5, 6, 7, 8]]
    faces = Faces.of(plate(3, "catmull-clark"))
    assert faces.take_out(5)
    assert sorted(map(len, faces.rings)) == [4, 4, 4, 4, 4, 8]
    assert faces.take_out(10)
    assert not {5, 6, 9, 10} & {v for ring in faces.rings for v in ring}


def test_boundary_vertices_and_creases_stay():
    mesh = plate(2, "catmull-clark")
    assert not Faces.of(mesh).take_out(0)
    ridge = Topology.from_faces(mesh.topology.face_offsets, mesh.topology.face_vertices, 9, [[3, 4], [4, 5]])
    assert not Faces.of(ControlMesh(ridge, mesh.points, "catmull-clark")).take_out(4)

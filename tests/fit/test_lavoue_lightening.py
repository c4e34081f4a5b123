"""Vertices taken out of open surfaces: none that is needed stays out, none that is not stays in."""

import numpy as np
import pytest

from shapes import grids
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
    i = grids.vertices(n + 1, n + 1)
    quads = grids.quads_of(i)
    corners = i[[0, 0, -1, -1], [0, -1, 0, -1]]
    topology = Topology.from_faces(4 * np.arange(n * n + 1), quads.ravel(), (n + 1) ** 2, corner_vertices=corners)
    return ControlMesh(topology, np.stack([x, y, 0 * x], -1).reshape(-1, 3) / n, scheme)


def fitted(mesh, *, within):
    """A plate that is taken for a fit of a finer one, and that."""
    dense = plate(8, mesh.scheme)
    triangles = grids.cut(dense.topology.face_vertices.reshape(-1, 4))
    target, field = mesh_target(dense.points, triangles), curvature_field(dense.points, triangles)
    return OpenFit(mesh, 0.0, 0.0, within, []), target, field, 1e-6


@pytest.mark.parametrize("scheme", SCHEMES)
def test_vertices_in_the_middle_of_a_plates_quads_go(scheme):
    """Those between four quads stay: a face of eight corners would be left."""
    mesh = plate(3, scheme)
    faces = Faces.of(mesh)
    for _ in range(9):
        ring = faces.rings.pop(0)
        faces.points.append(np.mean([faces.points[v] for v in ring], axis=0))
        faces.rings += [[a, b, len(faces.points) - 1] for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    found = lightened(*fitted(faces.frozen(mesh), within=True))
    assert found.within
    assert found.mesh.topology.face_count == 9
    np.testing.assert_allclose(found.mesh.points, mesh.points, atol=1e-5)


def test_one_that_is_not_within_is_returned_as_it_is():
    given = fitted(plate(4, "catmull-clark"), within=False)
    assert lightened(*given) is given[0]


def test_what_taking_out_leaves_with_two_faces_goes_as_well():
    """Vertex 4 in the middle of a square, and 5 between it and a corner: without 4 the latter had two faces."""
    mesh = plate(1, "catmull-clark")
    faces = Faces.of(mesh)
    faces.points += [np.array([0.5, 0.5, 0]), np.array([0.25, 0.25, 0])]
    corners = faces.rings[0]
    a, b, c, d = corners
    faces.rings = [[a, b, 5], [b, 4, 5], [d, a, 5], [d, 5, 4], [b, c, 4], [c, d, 4]]
    assert faces.take_out(4)
    assert {v for ring in faces.rings for v in ring} == {0, 1, 2, 3, 5}
    assert sorted(map(len, faces.rings)) == [3, 3, 4]
    assert not Faces.of(plate(2, "catmull-clark")).take_out(4)


def test_boundary_vertices_and_creases_stay():
    mesh = plate(2, "catmull-clark")
    assert not Faces.of(mesh).take_out(0)
    faces = Faces([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], list(mesh.points[:5]), {frozenset((0, 4)): 1.0})
    assert not faces.take_out(4)
    faces.creases.clear()
    assert faces.take_out(4)

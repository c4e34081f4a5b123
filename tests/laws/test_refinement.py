"""Refinement and patches are two roads to one surface."""

import numpy as np
import pytest

from shapes.parameters import CASES, CORNERS, DUAL, child_of, inside, parents, size, surface_of
from shapes.zoo import euler, scattered
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh


def refined(surface):
    step = surface.scheme.refine(surface.topology)
    return ControlMesh(step.child, step.matrix @ surface.control_mesh.points)


def test_rows_of_refinement_and_of_the_limit_sum_to_one(surface):
    for matrix in (surface.scheme.refine(surface.topology).matrix, surface.scheme.limit_rows(surface.topology)):
        assert np.abs(matrix.sum(axis=1) - 1).max() < 1e-14


def test_child_topology_keeps_genus_boundary_creases_and_corners(surface):
    parent, step = surface.topology, surface.scheme.refine(surface.topology)
    child = step.child
    assert euler(child) == euler(parent)
    pinned = parent.corner_sharpness > 1
    assert (child.corner_sharpness > 0).sum() == pinned.sum()
    moved = (step.matrix @ surface.control_mesh.points)[child.corner_sharpness > 0]
    np.testing.assert_array_equal(moved, surface.control_mesh.points[pinned])
    assert step.matrix.shape == (child.vertex_count, parent.vertex_count)
    if surface.scheme.name in DUAL:
        return
    assert child.boundary_edges.sum() == 2 * parent.boundary_edges.sum()
    lasting = parent.sharpness[parent.crease_edges]
    np.testing.assert_array_equal(
        np.sort(child.sharpness[child.crease_edges]), np.sort(np.repeat(lasting[lasting > 1] - 1, 2))
    )


def test_points_alone_give_what_matrices_give(surface):
    """Refined and limit points, computed with and without rows."""
    scheme, t, points = surface.scheme, surface.topology, scattered(surface.control_mesh).points
    step = scheme.refine(t)
    np.testing.assert_allclose(step.refined(points), step.matrix @ points, atol=1e-13)
    np.testing.assert_allclose(scheme.limit_points(t, points), scheme.limit_rows(t) @ points, atol=1e-13)


@pytest.mark.parametrize(("scheme", "name"), [case for case in CASES if case[0] not in DUAL])
def test_limit_rows_are_a_left_fixed_point_of_refinement(scheme, name):
    """The limit point of a vertex is the same whether taken now or one level later."""
    surface = surface_of(scheme, name)
    points = surface.control_mesh.points
    fine = refined(surface)
    later = surface.scheme.limit_rows(fine.topology) @ fine.points
    np.testing.assert_allclose(later[: len(points)], surface.vertex_limits(), rtol=0, atol=1e-14 * 10 * size(fine))


def test_limit_equals_deep_refinement_at_all_dyadic_points(surface):
    scheme, topology, domain = surface.scheme, surface.topology, surface.domain
    strewn = surface.with_points(scattered(surface.control_mesh, 1).points)
    points = np.hstack([surface.control_mesh.points, strewn.control_mesh.points])
    cell = np.arange(domain.face_count)
    place = np.array([np.vstack([CORNERS[int(n)], np.zeros((4 - n, 2))]) for n in domain.shape])
    for _ in range(4 if topology.face_count < 40 else 2):
        (parent, corners), step = parents(scheme.name, topology), scheme.refine(topology)
        place, cell = at(place[parent], domain.shape[parent], corners), cell[parent]
        topology, points = step.child, step.matrix @ points
        domain = scheme.domain(topology)
    limits = scheme.limit_rows(topology) @ points
    row, corner = np.nonzero(domain.vertex >= 0)
    value = [s.evaluate(cell[row], place[row, corner]).position for s in (surface, strewn)]
    gap = np.abs(np.hstack(value) - limits[domain.vertex[row, corner]]).reshape(-1, 2, 3).max(axis=(0, 2))
    assert (gap < 1e-12 * np.array([size(surface.control_mesh), size(strewn.control_mesh)])).all()


def at(place, shape, uv):
    """Parameters (k, c, 2) in cells whose corners lie at `place` (k, 4, 2) in larger cells, seen in those."""
    last = np.where((shape == 3)[:, None], place[:, 2], place[:, 3])
    axes = np.stack([place[:, 1] - place[:, 0], last - place[:, 0]], axis=1)
    return place[:, None, 0] + np.einsum("kcd,kdx->kcx", uv, axes)


def test_the_refined_mesh_has_the_same_surface(surface):
    fine = LimitSurface(refined(surface), surface.scheme)
    face, uv = inside(surface.domain, per_cell=8, margin=0.01)
    child, local, jacobian = child_of(surface.scheme.name, surface.topology, face, uv)
    coarse, same = surface.evaluate(face, uv, 2), fine.evaluate(child, local, 2)
    length = size(surface.control_mesh)
    assert np.abs(coarse.position - same.position).max() < 1e-13 * 10 * length
    first = np.einsum("kcp,kcx->kpx", jacobian, same.first)
    scale = np.maximum(np.abs(coarse.first).max(axis=(1, 2), keepdims=True), length)
    assert (np.abs(first - coarse.first) / scale).max() < 1e-11
    second = same.second[:, [0, 1, 1, 2]].reshape(-1, 2, 2, 3)
    second = np.einsum("kcp,kdq,kcdx->kpqx", jacobian, jacobian, second).reshape(-1, 4, 3)[:, [0, 1, 3]]
    scale = np.maximum(np.abs(coarse.second).max(axis=(1, 2), keepdims=True), length)
    assert (np.abs(second - coarse.second) / scale).max() < 1e-10


def test_vertex_limits_are_the_surface_at_the_corners_of_cells(surface):
    domain = surface.domain
    face, corner = np.nonzero(domain.vertex >= 0)
    uv = np.array([CORNERS[int(domain.shape[f])][c] for f, c in zip(face, corner, strict=True)])
    limits = surface.vertex_limits()[domain.vertex[face, corner]]
    value = surface.evaluate(face, uv).position
    assert np.abs(value - limits).max() < 1e-13 * size(surface.control_mesh)

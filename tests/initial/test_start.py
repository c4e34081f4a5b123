"""First control meshes for fits: what the scheme takes, whatever the target is like."""

import numpy as np
import trimesh

import subdfit
from subdfit.initial.start import start_mesh
from subdfit.limit import LimitSurface
from subdfit.target.bvh import TriangleTree
from subdfit.target.target import mesh_target

BACK_TO_BACK = np.array([[0, 1, 2], [0, 2, 1]])


def ball(segments=12):
    """A ball of quads cut in two, with poles."""
    angle, height = 2 * np.pi * np.arange(segments) / segments, np.pi * np.arange(1, segments) / segments
    rings = [[np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)] for h in height for a in angle]
    points = np.array([*rings, [0, 0, 1], [0, 0, -1]])
    rows = np.arange(len(rings)).reshape(-1, segments)
    after = np.roll(rows, -1, axis=1)
    a, b, c, d = (part.ravel() for part in (rows[:-1], rows[1:], after[1:], after[:-1]))
    top, bottom = np.full(segments, len(rings)), np.full(segments, len(rings) + 1)
    caps = [np.column_stack([top, rows[0], after[0]]), np.column_stack([bottom, after[-1], rows[-1]])]
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d]), *caps])


def with_a_sheet():
    """A ball, and beside it a triangle's two sides."""
    points, triangles = ball()
    away = np.array([[3, 0, 0], [3, 1, 0], [3, 0, 1]], float)
    return np.concatenate([points, away]), np.concatenate([triangles, len(points) + BACK_TO_BACK])


def test_of_two_faces_back_to_back_one_is_left():
    points, triangles = with_a_sheet()
    mesh = start_mesh(mesh_target(points, triangles), len(points), 0.01)
    assert len(LimitSurface(mesh, "loop").topology.triangles) == len(triangles) - 1
    closed = start_mesh(mesh_target(*ball()), len(points), 0.01)
    assert not closed.topology.boundary_edges.any()


def test_a_part_with_faces_back_to_back_is_fitted():
    result = subdfit.fit(with_a_sheet(), max_error="1%", creases="none")
    assert result.status == "within_tolerance"
    assert result.certified


def test_a_small_detail_makes_the_start_finer_there_alone():
    """A needle on a ball, which a start as coarse as the ball allows would cut off."""
    fine = trimesh.creation.icosphere(6)
    points = np.array(fine.vertices)
    beside = np.linalg.norm(points - points[7], axis=1)
    points *= 1 + 0.15 * np.exp(-((beside / 0.03) ** 2))[:, None]
    mesh, smooth = (start_mesh(mesh_target(p, fine.faces, creases="none"), None, 1e-3) for p in (points, fine.vertices))
    distance = TriangleTree(mesh.points, mesh.topology.triangles).closest(points).distance
    assert distance.max() <= 4e-3
    assert len(mesh.points) < 1.2 * len(smooth.points)

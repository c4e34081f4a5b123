"""First control meshes for fits: what the scheme takes, whatever the target is like."""

import numpy as np
import trimesh

import subdfit
from shapes import grids
from shapes.plates import bent_plate
from subdfit.initial.start import start_mesh
from subdfit.limit import LimitSurface
from subdfit.target.bvh import SegmentTree, TriangleTree
from subdfit.target.curves import boundary_edges
from subdfit.target.normals import face_normals
from subdfit.target.target import mesh_target

BACK_TO_BACK = np.array([[0, 1, 2], [0, 2, 1]])


def ball(segments=12):
    """A ball of quads cut in two, with poles."""
    angle, height = 2 * np.pi * np.arange(segments) / segments, np.pi * np.arange(1, segments) / segments
    rings = [[np.sin(h) * np.cos(a), np.sin(h) * np.sin(a), np.cos(h)] for h in height for a in angle]
    points = np.array([*rings, [0, 0, 1], [0, 0, -1]])
    rows = grids.vertices(segments - 1, segments)
    after = np.roll(rows, -1, axis=1)
    top, bottom = np.full(segments, len(rings)), np.full(segments, len(rings) + 1)
    caps = [np.column_stack([top, rows[0], after[0]]), np.column_stack([bottom, after[-1], rows[-1]])]
    return points, np.concatenate([grids.triangles_of(grids.wrapped(rows)), *caps])


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


def thread_round_a_ball(lift, radius, waves, around=800, sides=6):
    """A closed thread that waves round a ball of radius .3, its middle lifted off that, and the ball."""
    ball = trimesh.creation.icosphere(6, radius=0.3)
    angle, turn = (2 * np.pi * np.arange(n) / n for n in (around, sides))
    middle = np.column_stack([np.cos(angle), np.sin(angle), np.sin(waves * angle) / 30])
    outwards = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    along = np.roll(outwards, -1, axis=0) - np.roll(outwards, 1, axis=0)
    across = np.cross(outwards, along / np.linalg.norm(along, axis=1, keepdims=True))
    ring = np.cos(turn)[:, None] * outwards[:, None] + np.sin(turn)[:, None] * across[:, None]
    points = ((0.3 + lift) * outwards[:, None] + radius * ring).reshape(-1, 3)
    a = np.arange(len(points)).reshape(around, sides)
    b, d = np.roll(a, -1, axis=0), np.roll(a, -1, axis=1)
    c = np.roll(b, -1, axis=1)
    thread = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return np.concatenate([points, ball.vertices]), np.concatenate([thread, len(points) + ball.faces])


def test_a_start_keeps_a_strand_and_what_it_runs_along_apart():
    """Along a thread two tolerances thick no face more than a tolerance off faces against what is nearest to it."""
    bound = 1e-3
    target = mesh_target(*thread_round_a_ball(2.5 * bound, bound, 24), creases="none")
    mesh = start_mesh(target, None, bound)
    triangles = mesh.topology.triangles
    found = target.tree.closest(mesh.points[triangles].mean(axis=1))
    facing = face_normals(mesh.points, triangles) * face_normals(target.points, target.triangles[found.triangle])
    assert not np.any((facing.sum(axis=1) < 0) & (found.distance > bound))
    assert len(mesh.points) < 0.05 * len(target.points)


def test_corners_of_a_sheet_are_corners_of_the_control_mesh_and_its_holes_stay_open():
    points, triangles = bent_plate()
    target = mesh_target(points, triangles)
    mesh = start_mesh(target, None, 0.005 * target.diagonal)
    corners = mesh.points[mesh.topology.corner_sharpness > 0]
    square = np.array([[0, 0, 0], [60, 0, 20], [0, 40, 0], [60, 40, 20]], float)
    np.testing.assert_allclose(corners[np.lexsort(corners[:, :2].T)], square, atol=1e-9)
    edges = boundary_edges(mesh.topology.triangles)
    rim = points[np.unique(target.boundary_edges)]
    assert SegmentTree(mesh.points, edges).closest(rim).distance.max() <= 4 * 0.005 * target.diagonal

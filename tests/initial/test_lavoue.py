"""A control mesh from boundaries and lines of curvature: each step, and whole surfaces with holes."""

from itertools import pairwise

import numpy as np
import pytest
import trimesh
from scipy.spatial import Delaunay

import subdfit
from shapes import grids
from shapes.zoo import euler
from subdfit.curves.loops import fit_loop
from subdfit.curves.polyline import Polyline
from subdfit.errors import InputError
from subdfit.initial.lavoue import BoundaryPolygon, boundary_start
from subdfit.initial.lavoue_contour import cut, passable, topologic_contour
from subdfit.initial.lavoue_convex import convex_parts, is_convex
from subdfit.initial.lavoue_crossing import Edges
from subdfit.initial.lavoue_scores import ScoredSurface
from subdfit.target.bvh import TriangleTree
from subdfit.target.curvature import curvature_field
from subdfit.target.curves import boundary_loops
from subdfit.target.features import mesh_edges


def plate(holes, step=0.1, size=(4.0, 2.0), bend=None):
    """A rectangle with round holes (x, y, radius), flat or rolled round y to a radius."""
    x, y = (np.arange(0, s + step / 2, step) for s in size)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    rings = []
    for cx, cy, r in holes:
        grid = grid[np.hypot(*(grid - [cx, cy]).T) > r + 0.6 * step]
        angle = np.linspace(0, 2 * np.pi, max(12, int(2 * np.pi * r / step)), endpoint=False)
        rings.append(np.stack([cx + r * np.cos(angle), cy + r * np.sin(angle)], 1))
    q = np.concatenate([grid, *rings])
    triangles = Delaunay(q, qhull_options="QJ Pp").simplices
    a, b, c = np.moveaxis(q[triangles], 1, 0)
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((area > 0)[:, None], triangles, triangles[:, ::-1])[np.abs(area) > 1e-6]
    centre = q[triangles].mean(axis=1)
    for cx, cy, r in holes:
        kept = np.hypot(*(centre - [cx, cy]).T) > r
        triangles, centre = triangles[kept], centre[kept]
    used, rows = np.unique(triangles, return_inverse=True)
    q = q[used]
    if bend is None:
        return np.column_stack([q, np.zeros(len(q))]), rows.reshape(-1, 3)
    angle = q[:, 0] / bend
    return np.stack([bend * np.sin(angle), q[:, 1], bend * np.cos(angle)], 1), rows.reshape(-1, 3)


def scored(points, triangles, paths="geodesic"):
    return ScoredSurface(points, triangles, curvature_field(points, triangles), paths)


def polygons(points, triangles, share=5e-3):
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    fits = [fit_loop(Polyline(points[c.vertices], closed=True), share * diagonal) for c in boundary_loops(triangles)]
    return [BoundaryPolygon(f.points, f.corners, f.limits) for f in fits]


def nearest(points, *places):
    return [int(np.argmin(np.linalg.norm(points - place, axis=1))) for place in places]


def corners_of(mesh):
    offsets = mesh.topology.face_offsets
    return [mesh.topology.face_vertices[a:b] for a, b in pairwise(offsets)]


@pytest.mark.parametrize("paths", ["geodesic", "dijkstra"])
def test_scores_on_a_cylinder(paths):
    """Along a line of curvature 0, across at 45 degrees 45, along the boundary 90."""
    points, triangles = plate([], bend=1.5)
    surface = scored(points, triangles, paths)
    at = lambda x, y: [1.5 * np.sin(x / 1.5), y, 1.5 * np.cos(x / 1.5)]  # noqa: E731
    ends = nearest(points, at(2, 0), at(2, 2), at(1, 0), at(3, 2), at(0, 0), at(4, 0))
    pairs = [(ends[0], ends[1]), (ends[2], ends[3]), (ends[4], ends[5])]
    score, length = surface.scores(surface.find(pairs))
    assert score[0] < 2
    assert score[1] == pytest.approx(np.degrees(np.arctan2(2 * 1.5 * np.sin(1 / 1.5), 2)), abs=6)
    assert score[2] > 85
    assert length[0] == pytest.approx(2, abs=1e-6)


def test_flat_surfaces_score_45_everywhere():
    points, triangles = plate([])
    surface = scored(points, triangles)
    ends = nearest(points, [0, 1, 0], [4, 1, 0], [1, 0, 0], [3, 2, 0])
    score, length = surface.scores(surface.find([(ends[0], ends[1]), (ends[2], ends[3])]))
    np.testing.assert_allclose(score, 45)
    np.testing.assert_allclose(length, [4, np.sqrt(8)], atol=1e-6)


def test_geodesics_do_not_depend_on_the_tessellation_and_edge_paths_do():
    """From corner to corner, the grid's edges are forced into steps unless its diagonals happen to run that way."""
    points, triangles = plate([])
    turned = points * [1, -1, 1] + [0, 2, 0], triangles[:, ::-1]
    ends = nearest(points, [0.5, 0.2, 0], [3.5, 1.7, 0])
    lengths = {}
    for paths in ("geodesic", "dijkstra"):
        for name, (p, t) in (("as it is", (points, triangles)), ("mirrored", turned)):
            a, b = ends if name == "as it is" else nearest(p, points[ends[0]], points[ends[1]])
            lengths[paths, name] = scored(p, t).scores(scored(p, t).find([(a, b)], paths))[1][0]
    exact = np.linalg.norm(points[ends[1]] - points[ends[0]])
    for name in ("as it is", "mirrored"):
        assert lengths["geodesic", name] == pytest.approx(exact, abs=1e-9)
        assert lengths["dijkstra", name] > exact * (1 - 1e-12)


def test_a_cut_from_rim_to_rim_joins_two_boundaries():
    points, triangles = plate([(2, 1, 0.5)])
    surface = scored(points, triangles)
    a, b = nearest(points, [0, 1, 0], [1.5, 1, 0])
    path = surface.edge_path(a, b)
    assert not surface.boundary[path[1:-1]].any()
    opened, origin = cut(surface, path)
    assert len(boundary_loops(triangles)) == 2
    assert len(boundary_loops(opened.triangles)) == 1
    assert len(opened.points) == len(points) + len(path)
    np.testing.assert_array_equal(opened.points, points[origin])


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_the_contour_goes_round_every_boundary_once_and_every_link_twice(count):
    points, triangles = plate([(0.8, 1, 0.4), (2, 0.8, 0.3), (3.2, 1.1, 0.5)][:count])
    loops = boundary_loops(triangles)
    anchors = np.concatenate([c.vertices[:: len(c.vertices) // 5][:5] for c in loops])
    loop_of = np.repeat(np.arange(len(loops)), 5)
    contour = topologic_contour(scored(points, triangles), anchors, loop_of)
    assert len(contour.links) == count
    times = np.bincount(contour.controls, minlength=len(anchors))
    np.testing.assert_array_equal(times, 1 + np.bincount(contour.links.ravel(), minlength=len(anchors)))
    round_ = list(zip(contour.controls, np.roll(contour.controls, -1), strict=True))
    known = {(k, k + 1 if k % 5 < 4 else k - 4) for k in range(len(anchors))}
    known |= {(a, b) for a, b in contour.links.tolist()} | {(b, a) for a, b in contour.links.tolist()}
    assert set(round_) == known
    edges = mesh_edges(contour.surface.points, contour.surface.triangles)
    assert len(contour.surface.points) - len(edges.vertices) + len(contour.surface.triangles) == 1


def test_the_cylinder_of_the_paper(meshes):
    """Figure 12c: ten control points and no edge but along the axis and the arcs; four quads span the body."""
    mesh = trimesh.load(meshes / "cylinder.ply", process=False)
    points = np.asarray(mesh.vertices)
    found = boundary_start(points, mesh.faces, polygons(points, mesh.faces))
    assert found.topology.vertex_count == 10
    assert [len(face) for face in corners_of(found)] == [4, 4, 4, 4]
    assert found.topology.corner_sharpness.astype(bool).sum() == 4
    assert found.scheme == "quad-triangle"


@pytest.mark.parametrize(("name", "loops"), [("holes", 7), ("mech-holes-shark", 4), ("plane_holes", 27), ("blade", 2)])
def test_real_surfaces_keep_their_topology(meshes, name, loops):
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    points = np.asarray(mesh.vertices)
    targets = [Polyline(points[c.vertices], closed=True) for c in boundary_loops(mesh.faces)]
    # Even control points serve here: what is tested is the topology, not the fit of the curves.
    arcs = [np.linspace(0, t.total, 8 if loops < 20 else 4, endpoint=False) for t in targets]
    given = [BoundaryPolygon(t.at(s), np.zeros(len(s), np.bool_), t.at(s)) for t, s in zip(targets, arcs, strict=True)]
    found = boundary_start(points, mesh.faces, given)
    assert euler(found.topology) == 2 - loops
    assert len({tuple(sorted(face)) for face in map(tuple, corners_of(found))}) == found.topology.face_count
    boundary = found.topology.edge_vertices[found.topology.boundary_edges]
    assert len(boundary) == sum(len(p.points) for p in given) == found.topology.vertex_count
    assert {len(face) for face in corners_of(found)} <= {3, 4}


def test_plate_with_holes_is_covered_without_overlap():
    points, triangles = plate([(1.2, 1, 0.5), (2.8, 1, 0.4)])
    found = boundary_start(points, triangles, polygons(points, triangles))
    areas = []
    for face in corners_of(found):
        x, y = found.points[face][:, :2].T
        areas.append((x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
    x, y = found.points[:, :2].T
    boundary = found.topology
    sides = np.flatnonzero(boundary.twin < 0)
    a, b = boundary.face_vertices[sides], boundary.face_vertices[boundary.following[sides]]
    assert min(areas) > 0
    assert sum(areas) == pytest.approx((x[a] * y[b] - x[b] * y[a]).sum() / 2)


def judged(mesh, points, triangles):
    """Share of the limit surface that faces against the target where it is nearest, and its area over the target's."""
    limit = subdfit.LimitSurface(mesh).tessellate(4, apart=True)
    found = trimesh.Trimesh(limit.points, limit.triangles, process=False)
    target = trimesh.Trimesh(points, triangles, process=False)
    nearest = TriangleTree(points, triangles).closest(found.triangles_center).triangle
    away = np.sum(found.face_normals * target.face_normals[nearest], axis=1) < 0
    return found.area_faces[away].sum() / found.area, found.area / target.area


@pytest.mark.parametrize(
    ("name", "share", "away", "covered"),
    [("holes", 5e-3, 0.01, 0.8), ("mech-holes-shark", 5e-3, 0.01, 0.8), ("blade", 5e-3, 0.1, 0.75)],
)
def test_real_starts_cover_the_target_once(meshes, name, share, away, covered):
    """Curves within .5 % of the diagonal bring blade's sheets as near together: which one is nearest is chance."""
    mesh = trimesh.load(meshes / f"{name}.ply", process=False)
    points = np.asarray(mesh.vertices)
    found, area = judged(boundary_start(points, mesh.faces, polygons(points, mesh.faces, share)), points, mesh.faces)
    assert found < away
    assert covered < area < 1.25


HOLES = [(1.0, 0.6), (3.0, 1.4), (3.0, 0.6), (1.0, 1.4), (2.0, 1.0), (0.4, 1.0)]


@pytest.mark.parametrize("paths", ["geodesic", "dijkstra"])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 6])
def test_starts_of_bent_plates_cover_them_once(count, paths):
    """Along a ruled plate many edges score near 0: none of them may run across a hole, or across another."""
    points, triangles = plate([(x, y, 0.2) for x, y in HOLES[:count]])
    points[:, 2] = (points[:, 0] / 4) ** 2 * 1.3
    found, area = judged(boundary_start(points, triangles, polygons(points, triangles), paths=paths), points, triangles)
    assert found < 1e-3
    assert 0.95 < area < 1.05


def test_paths_pass_between_vertices_of_the_boundary():
    """A ring of one row of triangles has no vertex inside; its paths begin and end on the rims and cross it."""
    angle = np.arange(12) * np.pi / 6
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    k, on = np.arange(12), (np.arange(12) + 1) % 12
    triangles = np.concatenate([np.stack([k, on, 12 + k], 1), np.stack([on, 12 + on, 12 + k], 1)])
    points = np.concatenate([2 * rim, rim])
    ring = scored(points, triangles)
    assert len(ring.edge_path(0, 14)) == 0
    opened = passable(ring)
    assert opened.area == pytest.approx(ring.area)
    path = opened.points[opened.edge_path(0, 14)]
    assert len(path) > 2
    assert np.linalg.norm(path[1:-1, :2], axis=1).max() < 2
    corners = opened.points[opened.triangles]
    assert np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2].min() > 0.01


def test_edges_cross_on_one_sheet_only():
    up = np.array([[0.0, 0, 1]])
    edge = Edges(np.array([[0, 1]]), np.array([[[-1.0, 0, 0], [1, 0, 0]]]), up)

    def crossed(a, b, ends=(2, 3), normal=up):
        return edge.crossed_by(Edges(np.array([ends]), np.array([[a, b]], float), normal))

    assert crossed([0, -1, 0.1], [0, 1, 0.1])
    assert crossed([1, 0, 0], [0, 1, 0])
    assert not crossed([0, 0.1, 0], [0, 1, 0])
    assert not crossed([0, -1, 0.1], [0, 1, 0.1], normal=-up)
    assert not crossed([0, -1, 1.5], [0, 1, 1.5])
    assert not crossed([1, 0, 0], [0, 1, 0], ends=(1, 2))


def test_points_of_no_triangle_do_not_count():
    """A face of a part, among all its points, has the control mesh that it has alone."""
    points, triangles = plate([(2, 1, 0.5)], bend=1.5)
    curves = polygons(points, triangles)
    alone = boundary_start(points, triangles, curves)
    among = boundary_start(np.concatenate([[[9.0, 9, 9]], points, [[8.0, 0, 0]]]), triangles + 1, curves)
    np.testing.assert_array_equal(among.topology.face_vertices, alone.topology.face_vertices)
    np.testing.assert_allclose(among.points, alone.points)


def test_dijkstra_is_there_by_name():
    points, triangles = plate([(2, 1, 0.5)], bend=1.5)
    found = boundary_start(points, triangles, polygons(points, triangles), paths="dijkstra")
    assert euler(found.topology) == 0


def test_convex_parts_of_a_triangulated_outline():
    """An L: two parts at best with any number of corners; quads where four is the most."""
    outline = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]], float)
    fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
    assert not is_convex(outline)
    parts = convex_parts(fan, outline, np.arange(6))
    assert sorted(len(part) for part in parts) == [4, 4]
    assert all(is_convex(outline[part]) for part in parts)
    square = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1.2, 0], [0, 1, 0]], float)
    square[1, 1] = -0.2
    hexagon = convex_parts([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], square, np.arange(6), most_corners=6)
    assert [sorted(part) for part in hexagon] == [[0, 1, 2, 3, 4, 5]]
    bent = outline + np.array([0, 0, 1]) * (np.arange(6) == 2)[:, None]
    assert len(convex_parts([[0, 1, 2], [0, 2, 3]], bent, np.arange(6))) == 2


def test_what_cannot_be_cut_is_refused():
    ball = trimesh.creation.icosphere(1)
    with pytest.raises(InputError, match="closed"):
        topologic_contour(scored(ball.vertices, ball.faces), np.array([0]), np.array([0]))
    ring = trimesh.creation.torus(1.0, 0.4, major_sections=16, minor_sections=12)
    with pytest.raises(InputError, match="handles"):
        topologic_contour(scored(ring.vertices, ring.faces[1:]), ring.faces[0], np.zeros(3, np.int64))
    points, triangles = plate([])
    with pytest.raises(InputError, match="polygons"):
        boundary_start(points, triangles, [])
    with pytest.raises(InputError, match="closed"):
        boundary_start(ball.vertices, ball.faces, [])
    with pytest.raises(InputError, match="paths"):
        boundary_start(points, triangles, [], paths="straight")
    with pytest.raises(InputError, match="most_corners"):
        boundary_start(points, triangles, [], most_corners=2)


@pytest.mark.parametrize(("turn", "inner"), [(1.5, 0.8), (2.6, 0.6)])
def test_no_face_is_a_sliver_along_a_rim(turn, inner):
    """The hollow rim of a winding strip: a chord along it would leave a face on the rim's other side."""
    angle, radius = np.meshgrid(np.linspace(0, turn, 40), np.linspace(inner, 1, 12), indexing="ij")
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.3 * angle], -1).reshape(-1, 3)
    triangles = grids.triangles_of(grids.vertices(40, 12).T)
    mesh = boundary_start(points, triangles, polygons(points, triangles, 1e-3))
    for corners in (mesh.points[face] for face in corners_of(mesh)):
        longest = np.linalg.norm(np.roll(corners, 1, axis=0) - corners, axis=1).max()
        area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)[2] / 2
        assert area > 0.05 * longest**2

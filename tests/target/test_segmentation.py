"""Segmentation: parts whose faces are known, and the steps one by one."""

from functools import cache

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from shapes import grids, milled, parts
from shapes.bad_meshes import shaken
from shapes.drilled import drilled_block
from subdfit.errors import InputError
from subdfit.limit.curvature import unit
from subdfit.mesh.short_edges import without_short_edges
from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.segmentation import SegmentationSettings, _without_folds, segment_mesh
from subdfit.target.segmentation_carrying import on_all_triangles
from subdfit.target.segmentation_clusters import cluster, grow
from subdfit.target.segmentation_facets import Facets
from subdfit.target.segmentation_gaps import crease_gaps
from subdfit.target.segmentation_merging import Adjacency, absorb, merge_regions, renumbered
from subdfit.target.segmentation_noise import noise_of, without_noise
from subdfit.target.segmentation_rectification import border_costs, rectify
from subdfit.target.segmentation_slivers import without_slivers
from subdfit.target.segmentation_tips import across_necks
from subdfit.target.target import mesh_target, point_target


def extruded(profile, kind, height=2.0, step=0.1, seed=None):
    """A wall over a profile (k, 2), open at both ends, and the kind of each triangle's piece of profile."""
    rows = int(height / step) + 1
    z = np.linspace(0, height, rows)
    if seed is not None:
        z = z + np.concatenate([[0], np.random.default_rng(seed).uniform(-0.3, 0.3, rows - 2) * step, [0]])
    points = np.stack([np.repeat(profile[:, 0], rows), np.repeat(profile[:, 1], rows), np.tile(z, len(profile))], 1)
    quads = grids.quads_of(grids.vertices(len(profile), rows))
    turned = np.arange(len(quads)) * 7 % 3 == 0
    quads[turned] = np.roll(quads[turned], 1, axis=1)
    return points, grids.cut(quads), np.tile(np.repeat(kind, rows - 1), 2)


def filleted_bend(radius=0.5, step=0.1):
    """Plane, quarter of a cylinder, plane, all tangent to one another; 0, 1, 2."""
    flat = np.arange(0, 2, step)
    angle = np.linspace(0, np.pi / 2, int(radius * np.pi / 2 / step) + 1)
    arc = np.stack([2 + radius * np.sin(angle), radius * np.cos(angle) - radius], 1)
    lines = [np.stack([flat, 0 * flat], 1), arc, np.stack([0 * flat + 2 + radius, -radius - flat - step], 1)]
    kind = np.repeat([0, 1, 2], [len(flat), len(arc) - 1, len(flat)])
    return extruded(np.concatenate(lines), kind)


def test_a_fold_between_two_faces_goes_to_one_of_them():
    """A small triangle that lies upside down on both faces beside it joins one, and does not join the two."""
    points = np.array([[0, 0, 0], [0, 1, 0], [-0.02, 0.5, 0], [-3, 0.5, 0], [3, 0.5, 0]])
    triangles = np.array([[1, 0, 3], [0, 1, 2], [2, 1, 4], [0, 2, 4]], np.int32)
    edges = mesh_edges(points, triangles)
    facets = Facets(points, triangles, edges, np.zeros(len(edges.vertices), np.bool_), 0.5)
    found = _without_folds(facets, np.array([0, 1, 2, 2]))
    assert found[2] == found[3] != found[0]
    assert found[1] in (found[0], found[2])


def agreement(found, known):
    """Share of triangles in the largest overlap of their known kind with a region of its own."""
    table = np.zeros((found.max() + 1, known.max() + 1))
    np.add.at(table, (found, known), 1)
    return table.max(axis=0).sum() / len(found)


def facets_of(points, triangles, radius=0.2):
    edges = mesh_edges(points, triangles)
    return Facets(np.asarray(points, float), np.asarray(triangles, np.int32), edges, edges.angle > 40, radius)


@pytest.mark.parametrize(("subdivisions", "height"), [(2, 1.0), (4, 1.0), (0, 1.0), (0, 0.02)])
def test_a_box_has_six_faces(subdivisions, height):
    mesh = trimesh.creation.box(extents=(height, 2.0, 3.0))
    for _ in range(subdivisions):
        mesh = mesh.subdivide()
    found = segment_mesh(mesh_target(mesh.vertices, mesh.faces))
    assert found.count == 6
    side = np.argmax(np.abs(mesh.face_normals), axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    assert agreement(found.labels, side) == 1.0
    assert len(found.feature_edges) == 12 * 2**subdivisions


def test_a_cylinder_has_three_faces_and_two_rims():
    points, triangles = parts.can()
    found = segment_mesh(mesh_target(points, triangles))
    assert found.count == 3
    rim = np.abs(points[found.feature_edges][:, :, 2])
    np.testing.assert_allclose(rim, 1.5)


def test_a_fillet_is_a_face_of_its_own():
    """Nothing is sharp here: the borders are where the curvature jumps, to within a row of triangles."""
    points, triangles, known = filleted_bend()
    found = segment_mesh(mesh_target(points, triangles))
    assert found.count == 3
    assert len(found.feature_edges) == 0
    assert agreement(found.labels, known) > 0.97


def test_a_gradual_bend_is_one_face():
    """An Euler spiral: curvature grows linearly along the profile, from none to one over a fifth of its length."""
    s = np.linspace(0, 4, 81)
    heading = 0.3 * s**2
    profile = np.cumsum(np.stack([np.cos(heading), np.sin(heading)], 1) * 0.05, axis=0)
    points, triangles, _ = extruded(profile, np.zeros(80, int), step=0.05)
    assert segment_mesh(mesh_target(points, triangles)).count == 1


def test_a_sphere_is_one_face():
    ball = trimesh.creation.icosphere(4)
    assert segment_mesh(mesh_target(ball.vertices, ball.faces)).count == 1


def test_needles_do_not_hide_faces():
    """Needles along the edges of a box, with normals that mean nothing, change neither regions nor features much."""
    mesh = trimesh.creation.box().subdivide().subdivide().subdivide()
    points, triangles = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    edges = mesh_edges(points, triangles)
    rng = np.random.default_rng(0)
    for edge in rng.choice(np.flatnonzero(edges.angle > 45), 20, replace=False):
        (a, b), (f, g) = edges.vertices[edge], edges.faces[edge]
        if np.isin(triangles[[f, g]], [a, b]).sum() < 4:
            continue
        middle = points[[a, b]].mean(axis=0) + rng.normal(size=3) * 2e-4
        points = np.vstack([points, middle])
        corners = triangles[f].tolist()
        k = corners.index(({*corners} - {a, b}).pop())
        c, d, e = corners[k], corners[k - 2], corners[k - 1]
        triangles[f] = c, d, len(points) - 1
        triangles = np.vstack([triangles, [[c, len(points) - 1, e], [len(points) - 1, d, e]]])
    assert len(triangles) > 12 * 4**3 + 30
    found = segment_mesh(mesh_target(points, triangles))
    assert found.count == 6
    assert len(found.labels) == len(triangles)
    assert np.all(np.sum(np.abs(np.abs(points[found.feature_edges]) - 0.5) < 1e-2, axis=2) >= 2)


@cache
def machined(path):
    """A model and the labels of its triangles."""
    mesh = trimesh.load(path, process=False)
    return mesh, segment_mesh(mesh_target(mesh.vertices, mesh.faces)).labels


def planes(mesh, share):
    """The exactly flat pieces of a part of at least some share of its area, as triangles, the largest first."""
    edges = mesh_edges(mesh.vertices, mesh.faces)
    piece = Facets(mesh.vertices, mesh.faces, edges, np.zeros(0, bool), 1.0).connected(edges.angle < 0.05)
    area = np.bincount(piece, mesh.area_faces) / mesh.area
    return [np.flatnonzero(piece == k) for k in np.argsort(-area, kind="stable") if area[k] >= share]


def held(mesh, labels, triangles):
    """The region that holds most of some triangles, the share of their area in it, and their share of its area."""
    overlap = np.bincount(labels[triangles], mesh.area_faces[triangles])
    region = int(np.argmax(overlap))
    shares = overlap[region] / np.array([mesh.area_faces[triangles].sum(), mesh.area_faces[labels == region].sum()])
    return region, *shares


@pytest.mark.parametrize(("name", "share", "count"), [("fandisk", 0.01, 10), ("casting", 0.05, 4)])
def test_machined_parts(meshes, name, share, count):
    """No region is in two pieces or crosses an edge of more than 40 degrees, and no two planes are one region."""
    mesh, labels = machined(meshes / f"{name}.ply")
    edges = mesh_edges(mesh.vertices, mesh.faces)
    whole = Facets(mesh.vertices, mesh.faces, edges, np.zeros(0, bool), 1.0)
    assert whole.connected(~whole.borders(labels)).max() == labels.max()
    parted = whole.connected(edges.angle <= 40)
    assert len(np.unique(np.stack([labels, parted]), axis=1).T) == labels.max() + 1
    found = [held(mesh, labels, plane) for plane in planes(mesh, share)]
    assert len(found) == len({region for region, *_ in found}) == count
    assert min(part for _, part, _ in found) > 0.5


def test_every_face_of_fandisk_is_a_region(meshes):
    """Counted in pictures from all sides.

    The large plane below, two at the sides; the top and the strip that bends up from it, parted by an edge that fades
    out; the blend on the top, the dome, its rounded edge, the plane within; two steps of two faces each, the wall under
    them and two undersides; the front end; the cove, and round the rib beside it five faces, two of them rounded edges.
    """
    mesh, labels = machined(meshes / "fandisk.ply")
    assert labels.max() + 1 == 23
    for plane in planes(mesh, 0.01):
        assert min(held(mesh, labels, plane)[1:]) > 0.88


def test_every_face_of_block_is_a_region(meshes):
    """Six sides, two studs with their ends, and four halves of two bores; the edge in which these cross fades out.

    Slivers beside edges are not exactly flat and may go either way.
    """
    mesh, labels = machined(meshes / "block.ply")
    assert labels.max() + 1 == 14
    centre = mesh.triangles_center - [1.8, 0, 0]
    stud = (np.abs(centre[:, 2]) > 10) & (np.abs(mesh.face_normals[:, 2]) < 0.1)
    ends = [np.flatnonzero(stud & (side * centre[:, 2] > 0)) for side in (-1, 1)]
    for end in ends:
        radius = np.linalg.norm(mesh.vertices[mesh.faces[end]][:, :, :2] - [1.8, 0], axis=2)
        np.testing.assert_allclose(radius, 7, rtol=0.01)
    faces = [*planes(mesh, 0.03), *ends]
    found = [held(mesh, labels, triangles) for triangles in faces]
    assert len({region for region, *_ in found}) == 10
    assert min(part for _, part, _ in found) == pytest.approx(1)
    assert min(of for *_, of in found) > 0.97
    inside = np.setdiff1d(np.arange(len(labels)), np.concatenate(faces))
    lengthwise = np.abs(centre[:, 0]) > np.abs(centre[:, 1])
    beyond = np.where(lengthwise, centre[:, 0], centre[:, 1]) > 0
    halves = [inside[(lengthwise[inside] == a) & (beyond[inside] == b)] for a in (False, True) for b in (False, True)]
    found = [held(mesh, labels, half) for half in halves]
    assert len({region for region, *_ in found}) == 4
    assert min(min(shares) for _, *shares in found) > 0.9


def test_every_bore_of_casting_is_a_region(meshes):
    """Eight bolt holes and the large bore; about fifty faces in all, whose blends leave some to taste."""
    mesh, labels = machined(meshes / "casting.ply")
    assert abs(labels.max() + 1 - 51) <= 4
    round_about = [k for k in range(labels.max() + 1) if is_bore(mesh, np.flatnonzero(labels == k))]
    assert len(round_about) == 9


def test_the_top_of_casting_and_its_round_end_are_faces(meshes):
    """The cover's top is a plane across y, which ends at its largest x and goes on as a cylinder along z."""
    mesh, labels = machined(meshes / "casting.ply")
    facing = [plane for plane in planes(mesh, 0.03) if mesh.face_normals[plane[0], 1] < -0.99]
    top = min(facing, key=len)
    corners = mesh.vertices[mesh.faces[top]].reshape(-1, 3)
    end = corners[:, 0].max()
    last = corners[corners[:, 0] > end - 1e-4, 2]
    x, _, z = mesh.triangles_center.T
    across, along = -mesh.face_normals[:, :2].T
    lengthwise = (np.abs(mesh.face_normals[:, 2]) < 0.02) & (across > 0.3) & (along > 0.05)
    bend = np.flatnonzero(lengthwise & (x > end) & (z > last.min()) & (z < last.max()))
    assert len(bend) > 100
    found = [held(mesh, labels, triangles) for triangles in (top, bend)]
    assert found[0][0] != found[1][0]
    assert [part for _, part, _ in found] == pytest.approx([1, 1])


def is_bore(mesh, triangles):
    """Whether triangles form a tube of one radius along y, closed round."""
    x, z = mesh.triangles_center[triangles][:, ::2].T
    a, b, _ = np.linalg.lstsq(np.stack([2 * x, 2 * z, np.ones(len(x))], 1), x**2 + z**2, rcond=None)[0]
    radius = np.hypot(x - a, z - b)
    outward = mesh.area_faces[triangles] @ mesh.face_normals[triangles] / mesh.area_faces[triangles].sum()
    upright = np.abs(mesh.face_normals[triangles, 1]).max() < 0.2
    return bool(upright and np.ptp(radius) < 0.1 * radius.mean() and np.abs(outward).max() < 0.05)


def test_a_crease_that_ends_just_short_of_the_rim_parts_a_face():
    """A sheet with a ridge that sinks to nothing on the way; nothing happens where it sinks half way."""
    x, y = (v.ravel() for v in np.meshgrid(np.arange(21.0), np.arange(21.0), indexing="ij"))
    i = grids.vertices(21, 21)
    triangles = grids.triangles_of(i)
    for end, count in ((16, 2), (10, 1)):
        points = np.column_stack([x, y, -np.abs(y - 10) * np.maximum(1 - x / (end + 2), 0)])
        edges = mesh_edges(points, triangles)
        ridge = np.isin(edges.vertices, i[: end + 1, 10]).all(axis=1)
        facets = Facets(points, triangles.astype(np.int32), edges, ridge, 1.5)
        labels = facets.connected(~ridge & ~across_necks(facets, 5.0))
        assert labels.max() + 1 == count
        if count == 2:
            assert agreement(labels, (facets.centres[:, 1] > 10).astype(np.int64)) == 1


@pytest.mark.parametrize("how", [{}, {"step": (0.2, 0.05)}, {"step": (0.05, 0.2)}, {"inside": False}])
def test_every_face_of_a_milled_plate_is_a_region(how):
    """Meshed evenly, stretched along either side, and with slivers from rim to rim."""
    part = milled.milled_plate(**how)
    found = segment_mesh(mesh_target(part.points, part.triangles))
    assert found.count == milled.FACES == part.faces.max() + 1
    assert agreement(found.labels, part.faces) == 1.0


@pytest.mark.parametrize(
    ("how", "share", "more", "alike"),
    [({}, 0.0005, 0, 0.99), ({}, 0.001, 2, 0.96), ({"inside": False}, 0.0005, 2, 0.98)],
)
def test_noise_changes_hardly_a_face_of_a_milled_plate(how, share, more, alike):
    part = milled.milled_plate(**how)
    found = segment_mesh(mesh_target(shaken(part.points, share)[0], part.triangles))
    assert milled.FACES <= found.count <= milled.FACES + more
    assert agreement(found.labels, part.faces) > alike


def test_noise_changes_no_face_of_a_drilled_block():
    """The noise is a thirteenth of the edges' length; features lie where they were."""
    points, triangles = drilled_block()
    known = segment_mesh(mesh_target(points, triangles))
    found = segment_mesh(mesh_target(shaken(points, 0.002)[0], triangles))
    assert found.count == known.count == 7
    assert agreement(found.labels, known.labels) > 0.99
    tree = cKDTree(points[known.feature_edges].reshape(-1, 3))
    assert tree.query(points[found.feature_edges].reshape(-1, 3))[0].max() < 0.11


def test_noise_is_measured():
    """To within a fifth where it is, and none where surfaces bend, have creases or are fine."""
    part = milled.milled_plate()
    ball = trimesh.creation.icosphere(4)
    for points, triangles in ((part.points, part.triangles), (ball.vertices, ball.faces), parts.can()):
        target = mesh_target(points, triangles)
        assert noise_of(target.points, target.triangles, target.crease_edges) == 0
        moved, size = shaken(points, 0.001)
        target = mesh_target(moved, triangles)
        assert noise_of(target.points, target.triangles, target.crease_edges) == pytest.approx(size, rel=0.2)


def test_noise_is_taken_from_a_sphere():
    """What is left of it is a third in distance and a quarter in direction."""
    ball = trimesh.creation.icosphere(4)
    moved, size = shaken(ball.vertices, 0.002)
    coarse = without_noise(moved, ball.faces, np.empty((0, 2), np.int64), size)
    before = trimesh.Trimesh(moved, ball.faces, process=False)
    after = trimesh.Trimesh(coarse.points, coarse.triangles, process=False)
    off = [np.std(np.linalg.norm(mesh.vertices, axis=1)) for mesh in (before, after)]
    turn = [
        np.sqrt(np.mean(np.sum((mesh.face_normals - unit(mesh.triangles_center)) ** 2, axis=1)))
        for mesh in (before, after)
    ]
    assert off[1] < off[0] / 3
    assert turn[1] < turn[0] / 4


def test_labels_and_features_are_carried_to_triangles_that_were_shrunk():
    """A box most of whose edges go: no triangle is left without a side, and the features are the box's edges only."""
    mesh = trimesh.creation.box().subdivide().subdivide().subdivide()
    points, triangles = np.array(mesh.vertices), np.asarray(mesh.faces)
    edges = mesh_edges(points, triangles)
    creases = edges.vertices[edges.angle > 45]
    weights = np.ones(len(points))
    weights[creases] = 1e6
    coarse = without_short_edges(points, triangles, 0.13, weights)
    assert 50 < len(coarse.rows) < len(triangles) / 2
    side = np.argmax(np.abs(mesh.face_normals), axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    labels, features = on_all_triangles(points, triangles, coarse, side[coarse.rows], coarse.edges(creases))
    assert agreement(labels, side) > 0.9
    border = facets_of(points, triangles).borders(labels)
    shared = edges_among(edges.vertices, features)
    assert np.count_nonzero(border & shared) > 0.9 * np.count_nonzero(border)
    assert border[shared].all()
    assert np.count_nonzero(border & (edges.angle > 45)) > 0.9 * len(creases)


def test_gaps_of_creases_are_found_and_smooth_borders_are_none():
    """A box three of whose edges are not known to be sharp, and one of whose sides is parted in two."""
    mesh = trimesh.creation.box().subdivide().subdivide().subdivide()
    points, triangles = np.array(mesh.vertices), np.asarray(mesh.faces)
    side = np.argmax(np.abs(mesh.face_normals), axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    side[(side == 5) & (mesh.triangles_center[:, 0] > 0)] = 6
    edges = mesh_edges(points, triangles)
    creases = edges.vertices[edges.angle > 45]
    hidden = np.isin(np.arange(len(creases)), [10, 11, 40])
    found = crease_gaps(points, triangles, side, creases[~hidden])
    np.testing.assert_array_equal(np.unique(np.sort(found, axis=1), axis=0), creases[hidden])


def test_points_are_refused():
    with pytest.raises(InputError, match="mesh"):
        segment_mesh(point_target(np.eye(3)))
    with pytest.raises(InputError, match="radius"):
        SegmentationSettings(radius=-1.0)
    with pytest.raises(InputError, match="classes"):
        SegmentationSettings(classes=0)


def test_clusters_of_separate_values_are_the_values():
    rng = np.random.default_rng(3)
    truth = rng.integers(4, size=500)
    values = np.array([[0, 0], [5, 0], [0, 5], [9, 9]])[truth] + 0.1 * rng.normal(size=(500, 2))
    found = cluster(values, rng.uniform(0.5, 2, 500), 4)
    assert agreement(found, truth) == 1.0
    assert len(np.unique(cluster(np.ones((7, 2)), np.ones(7), 4))) == 1


def test_regions_are_connected_and_do_not_cross_sharp_edges():
    mesh = trimesh.creation.box().subdivide().subdivide()
    facets = facets_of(mesh.vertices, mesh.faces)
    assert grow(facets, np.zeros(len(mesh.faces), np.int64)).max() + 1 == 6
    two = (mesh.triangles_center[:, 2] > 0.1).astype(np.int64)
    assert grow(facets, two).max() + 1 == 10


def test_merging_keeps_count_of_areas_perimeters_and_borders():
    points, triangles, known = filleted_bend()
    facets = facets_of(points, triangles)
    curvatures, _ = facets.curvature()
    graph = Adjacency(facets, renumbered(known), curvatures)
    graph.merge(0, 1)
    fresh = Adjacency(facets, renumbered(np.where(known == 1, 0, known)), curvatures)
    np.testing.assert_allclose([graph.area[0], graph.perimeter[0]], [fresh.area[0], fresh.perimeter[0]])
    assert graph.turn_of_means(0, 2) == pytest.approx(fresh.turn_of_means(0, 1))
    assert graph.borders[0][2].length == pytest.approx(fresh.borders[0][1].length)


def test_turn_of_a_fillet_is_its_angle():
    """A quarter of a cylinder turns by 90 degrees against a plane: curvature 1/r over a width of r pi/2."""
    points, triangles, known = filleted_bend()
    facets = facets_of(points, triangles)
    exact = np.where(known == 1, 2.0, 0.0)[:, None] * [0, 1]
    graph = Adjacency(facets, known, exact)
    width = 0.25 * np.pi * 2.0 / (0.25 * np.pi + 2.0)  # area over half the perimeter
    assert graph.turn_of_means(0, 1) == pytest.approx(np.degrees(2.0 * width), rel=0.02)
    assert merge_regions(facets, known, exact, Adjacency.turn_of_means, 100.0).max() == 0
    assert merge_regions(facets, known, exact, Adjacency.turn_of_means, 60.0).max() == 2


def test_remnants_go_to_the_neighbour_they_share_most_with():
    points, triangles, known = filleted_bend()
    facets = facets_of(points, triangles)
    labels = known.copy()
    inside = np.flatnonzero(known == 0)
    labels[inside[np.argmin(np.linalg.norm(facets.centres[inside] - [1, 0, 1], axis=1))]] = 3
    np.testing.assert_array_equal(absorb(facets, labels, Adjacency.thickness, 0.1), known)


def test_rectified_borders_follow_the_jump_and_straighten():
    points, triangles, known = filleted_bend()
    facets = facets_of(points, triangles, 0.15)
    curvatures, directions = facets.curvature()
    rng = np.random.default_rng(5)
    frayed = known.copy()
    wave = rng.uniform(-0.15, 0.15, len(known))
    frayed[facets.centres[:, 0] < 2 + wave] = 0
    frayed[(facets.centres[:, 0] >= 2 + wave) & (known == 0)] = 1
    costs = border_costs(facets, directions)
    straight = rectify(facets, frayed, curvatures, costs)
    assert agreement(straight, known) > agreement(frayed, known)
    assert facets.lengths[facets.borders(straight)].sum() < facets.lengths[facets.borders(frayed)].sum()
    assert agreement(straight, known) > 0.97


def test_borders_are_cheapest_along_lines_of_curvature():
    points, triangles = parts.can(sections=48, rows=24)
    facets = facets_of(points, triangles, 0.4)
    _, directions = facets.curvature()
    share = border_costs(facets, directions) / facets.lengths * (1 + facets.edges.angle / 20)
    along = facets.points[facets.edges.vertices]
    along = np.abs((along[:, 1] - along[:, 0])[:, 2]) / facets.lengths
    wall = (np.abs(facets.points[facets.edges.vertices][:, :, 2]) < 1.2).all(axis=1)
    assert share[wall & (along > 0.999)].max() < 0.35
    assert share[wall & (np.abs(along - np.sqrt(0.5)) < 0.1)].min() > 0.7
    assert np.all(border_costs(facets, directions)[facets.sharp] == 0)


NONE = np.empty((0, 2), np.int64)


def test_needles_are_flipped_away_and_nothing_else_changes():
    mesh = trimesh.creation.icosphere(3)
    np.testing.assert_array_equal(without_slivers(mesh.vertices, mesh.faces, NONE)[0], mesh.faces)
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 1e-4, 0]], float)
    needle = np.array([[0, 1, 4], [4, 1, 2], [4, 2, 3], [4, 3, 0]])
    lower = np.array([[0.5, -1, 0]])
    faces = np.vstack([needle, [[1, 0, 5]]])
    found, _ = without_slivers(np.vstack([points, lower]), faces, NONE)
    assert {tuple(sorted(f)) for f in found.tolist()} == {(1, 2, 4), (2, 3, 4), (0, 3, 4), (0, 4, 5), (1, 4, 5)}


def test_flips_of_needles_fold_nothing():
    """Two needles in a plane whose quad is hollow: a flip would make both higher, and turn one over."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0.1, 0.001, 0], [-0.2, -0.001, 0]])
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    found, _ = without_slivers(points, faces, NONE)
    a, b, c = np.moveaxis(points[found], 1, 0)
    assert np.all(np.cross(b - a, c - a)[:, 2] > 0)


@pytest.mark.parametrize(
    ("height", "creases", "flips"), [(1e-3, NONE, True), (1e-3, np.array([[0, 1]]), False), (1e-2, NONE, False)]
)
def test_flips_keep_creases_and_the_surface(height, creases, flips):
    """A needle in a wall along its upper edge: a flip takes the edge away and lowers it by the needle's height."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0.5, 0, -height], [0.5, 0, -1], [0.5, 1, 0]])
    faces = np.array([[0, 1, 4], [1, 0, 2], [0, 3, 2], [3, 1, 2]])
    found, kept = without_slivers(points, faces, creases)
    assert edges_among(np.array([[0, 1]]), mesh_edges(points, found).vertices)[0] != flips
    np.testing.assert_array_equal(kept, creases)


def test_a_triangle_folded_over_its_neighbours_is_no_face():
    """A vertex of a plane pushed across the side opposite: a triangle at a sharp edge lies upside down on others."""
    mesh = trimesh.creation.box().subdivide().subdivide().subdivide()
    points = np.array(mesh.vertices)
    off = 0.5 - np.sort(np.abs(points), axis=1)[:, 1]
    face = np.flatnonzero(np.sort(off[mesh.faces], axis=1) @ [1, 1, 1] == 0.25)[0]
    vertex = mesh.faces[face][np.argmax(off[mesh.faces[face]])]
    others = mesh.faces[face][mesh.faces[face] != vertex]
    points[vertex] += 1.2 * (points[others].mean(axis=0) - points[vertex])
    moved = trimesh.Trimesh(points, mesh.faces, process=False)
    assert np.sum(np.einsum("fi,fi->f", moved.face_normals, mesh.face_normals) < -0.99) == 1
    found = segment_mesh(mesh_target(points, mesh.faces))
    assert found.count == 6
    side = np.argmax(np.abs(mesh.face_normals), axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    assert agreement(found.labels, side) == 1.0

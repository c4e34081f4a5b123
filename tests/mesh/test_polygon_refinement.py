"""Local refinement of polygons: what stays, what is kept, and which faces come of which marks."""

import itertools

import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData
from subdfit.mesh.polygon_refinement import refine_polygons, template

BOTH = pytest.mark.parametrize("polygons", [True, False])


def sheet(n: int, closed: bool = False) -> ControlMesh:
    """A flat square of n x n quads; closed, a torus of them."""
    size = n if closed else n + 1
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    corner = [((i + a) % size) * size + (j + b) % size for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    x, y = (a.ravel() for a in np.meshgrid(np.arange(size), np.arange(size), indexing="ij"))
    if closed:
        u, v = 2 * np.pi * x / n, 2 * np.pi * y / n
        points = np.column_stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)])
    else:
        points = np.column_stack([x, y, 0 * x]).astype(float)
    return polygons_mesh(points, np.column_stack(corner).tolist())


def polygons_mesh(points: np.ndarray, faces: list[list[int]], **tags: np.ndarray) -> ControlMesh:
    offsets = np.concatenate([[0], np.cumsum([len(f) for f in faces])])
    return ControlMesh.from_data(MeshData(np.asarray(points, float), offsets, np.concatenate(faces), **tags))


def regular(count: int) -> ControlMesh:
    """One regular polygon."""
    angle = 2 * np.pi * np.arange(count) / count
    return polygons_mesh(np.column_stack([np.cos(angle), np.sin(angle), 0 * angle]), [list(range(count))])


def areas(mesh: ControlMesh) -> np.ndarray:
    """Signed areas of flat faces."""
    t = mesh.topology
    a, b = mesh.points[t.face_vertices], mesh.points[t.face_vertices[t.following]]
    return np.bincount(t.face, a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def sizes(mesh: ControlMesh) -> np.ndarray:
    return np.diff(mesh.topology.face_offsets)


@BOTH
def test_any_marks_cut_the_square_into_convex_parts_that_fill_it(polygons: bool) -> None:
    rng = np.random.default_rng(7)
    for share in (0.02, 0.1, 0.4):
        mesh = sheet(6)
        for _ in range(4):
            mesh = refine_polygons(mesh, rng.random(len(mesh.topology.twin)) < share, polygons).mesh
            area = areas(mesh)
            assert area.min() > 0
            assert area.sum() == pytest.approx(36)
            assert set(sizes(mesh)) <= ({4, 5} if polygons else {3, 4})
            assert mesh.topology.valence[~mesh.topology.boundary_vertices].min() >= 3


@BOTH
def test_every_marked_edge_is_halved_where_it_lies(polygons: bool) -> None:
    mesh = sheet(5)
    t = mesh.topology
    marked = np.random.default_rng(1).random(len(t.twin)) < 0.2
    found = refine_polygons(mesh, marked, polygons)
    assert set(t.edge[marked]) <= set(t.edge[found.halved])
    k = t.vertex_count
    np.testing.assert_array_equal(found.mesh.points[:k], mesh.points)
    middles = mesh.points[t.edge_vertices[t.edge[found.halved]]].mean(axis=1)
    np.testing.assert_allclose(found.mesh.points[k : k + len(middles)], middles)
    centres = [mesh.points[t.face_vertices[t.face == f]].mean(axis=0) for f in found.centred]
    np.testing.assert_allclose(found.mesh.points[k + len(middles) :], np.reshape(centres, (-1, 3)))


def test_all_marks_refine_as_catmull_clark_cuts() -> None:
    mesh = sheet(4, closed=True)
    t = mesh.topology
    found = refine_polygons(mesh, np.ones(len(t.twin), np.bool_))
    assert found.mesh.topology.face_count == 4 * t.face_count
    assert found.mesh.topology.vertex_count == t.vertex_count + t.edge_count + t.face_count
    assert set(sizes(found.mesh)) == {4}
    assert set(found.mesh.topology.valence) == {4}


def test_a_strip_is_halved_along_itself() -> None:
    mesh = sheet(5)
    t = mesh.topology
    a, b = mesh.points[t.face_vertices], mesh.points[t.face_vertices[t.following]]
    strip = (np.minimum(a[:, 0], b[:, 0]) == 2) & (np.abs(a[:, 0] - b[:, 0]) == 1)
    finer = refine_polygons(mesh, strip).mesh
    assert finer.topology.face_count == 30
    assert set(sizes(finer)) == {4}


@pytest.mark.parametrize(
    ("count", "marks", "polygons", "expected"),
    [
        (4, [0], True, [5]),
        (4, [0], False, [3, 4]),
        (4, [0, 2], True, [4, 4]),
        (4, [1, 2], True, [4, 4, 4]),
        (4, [0, 1, 2], True, [4, 5]),
        (4, [0, 1, 2], False, [3, 4, 4]),
        (4, [0, 1, 2, 3], False, [4, 4, 4, 4]),
        (3, [1], True, [3, 3]),
        (3, [0, 2], True, [3, 4]),
        (3, [0, 1, 2], True, [4, 4, 4]),
        (3, [0, 1, 2], False, [3, 3, 3, 3]),
    ],
)
def test_one_face_becomes(count: int, marks: list[int], polygons: bool, expected: list[int]) -> None:
    marked = np.zeros(count, np.bool_)
    marked[marks] = True
    mesh = regular(count)
    finer = refine_polygons(mesh, marked, polygons).mesh
    assert sorted(sizes(finer)) == expected
    assert areas(finer).min() > 0
    assert areas(finer).sum() == pytest.approx(areas(mesh).sum())


def test_a_pentagon_is_cut_through_the_vertex_it_has() -> None:
    mesh = refine_polygons(regular(4), np.array([True, False, False, False])).mesh
    t = mesh.topology
    far = next(h for h in range(5) if {t.face_vertices[h], t.face_vertices[t.following[h]]} == {2, 3})
    finer = refine_polygons(mesh, np.arange(5) == far).mesh
    assert sorted(sizes(finer)) == [4, 4]
    assert finer.topology.vertex_count == 6


def test_half_a_side_is_not_halved_before_its_face_is_cut() -> None:
    mesh = refine_polygons(regular(4), np.array([True, False, False, False])).mesh
    t = mesh.topology
    half = next(h for h in range(5) if {t.face_vertices[h], t.face_vertices[t.following[h]]} == {0, 4})
    finer = refine_polygons(mesh, np.arange(5) == half).mesh
    assert sorted(sizes(finer)) == [4, 5]


def test_a_larger_polygon_is_cut_at_all_sides() -> None:
    # Of a seven-gon's corners two count as lying within sides.
    finer = refine_polygons(regular(7), np.arange(7) == 3).mesh
    assert set(sizes(finer)) <= {4, 5}
    assert areas(finer).sum() == pytest.approx(areas(regular(7)).sum())


@BOTH
def test_creases_and_corners_keep_their_tags(polygons: bool) -> None:
    flat = sheet(4)
    row = [5 * 2 + j for j in range(5)]
    pairs = np.array(list(itertools.pairwise(row)))
    data = flat.to_data()
    mesh = ControlMesh.from_data(
        MeshData(
            data.points,
            data.face_offsets,
            data.face_vertices,
            crease_edges=pairs,
            crease_sharpness=np.array([1.5, 2.0, 10.0, 10.0]),
            corner_vertices=np.array([12]),
            corner_sharpness=np.array([3.0]),
        )
    )
    finer = refine_polygons(mesh, np.ones(len(mesh.topology.twin), np.bool_), polygons).mesh
    t = finer.topology
    assert len(t.crease_edges) == 8
    ends = finer.points[t.edge_vertices[t.crease_edges]]
    np.testing.assert_allclose(ends[:, :, 0], 2.0)
    middle = ends[:, :, 1].mean(axis=1)
    expected = np.array([1.5, 2.0, np.inf, np.inf])[middle.astype(int)]
    np.testing.assert_array_equal(t.sharpness[t.crease_edges], expected)
    assert t.corner_sharpness[12] == 3.0
    assert np.count_nonzero(t.corner_sharpness) == 1


@BOTH
@pytest.mark.parametrize("sides", [3, 4])
def test_every_template_uses_each_side_once(polygons: bool, sides: int) -> None:
    for code in range(2**sides):
        split = tuple(bool(code >> i & 1) for i in range(sides))
        parts = template(split, polygons)
        ring = [s for s in range(2 * sides) if s % 2 == 0 or split[s // 2]]
        steps = [(part[i], part[(i + 1) % len(part)]) for part in parts for i in range(len(part))]
        outer = {(a, b) for a, b in zip(ring, ring[1:] + ring[:1], strict=True)}
        assert len(steps) == len(set(steps))
        assert {(a, b) for a, b in steps if (b, a) not in steps} == outer
        assert max(len(part) for part in parts) <= (5 if polygons else 4)


def test_marks_must_fit() -> None:
    with pytest.raises(InputError, match="one bool"):
        refine_polygons(sheet(2), np.ones(3, np.bool_))
    with pytest.raises(InputError, match="face 0 has 5 corners"):
        refine_polygons(regular(5), np.ones(5, np.bool_), polygons=False)

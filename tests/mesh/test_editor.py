"""The mesh editor keeps manifold, orientation, curves and carried points through any series of edits."""

from collections import Counter

import numpy as np
import pytest
import trimesh

from shapes.zoo import grid_data
from subdfit import parallel
from subdfit.errors import InputError
from subdfit.mesh.editor import MeshEditor


def tetrahedron():
    points = np.array([[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]], float)
    return points, np.array([[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]])


def octahedron():
    points = np.vstack([np.eye(3), -np.eye(3)])
    return points, np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


def grid(rows, columns, **closed):
    """Coordinates of a plane grid's vertices, and its triangles."""
    points, triangles = grid_data(rows, columns, **closed)
    return points.T, triangles


def torus(rows=7, columns=9):
    (t, s, _), triangles = grid(rows, columns, close_rows=True, close_columns=True)
    s, t = 2 * np.pi * s / rows, 2 * np.pi * t / columns
    radius = 3 + np.cos(s)
    return np.stack([radius * np.cos(t), radius * np.sin(t), np.sin(s)], 1), triangles[:, ::-1].copy()


def disc(size=6):
    (x, y, _), triangles = grid(size, size)
    return np.stack([x, y, 0.02 * (x - 3) * (y - 2)], 1), triangles


def annulus(rows=3, columns=12):
    (t, r, _), triangles = grid(rows, columns, close_columns=True)
    t *= 2 * np.pi / columns
    return np.stack([(2 + r) * np.cos(t), (2 + r) * np.sin(t), 0 * r], 1), triangles[:, ::-1].copy()


SHAPES = {
    "tetrahedron": tetrahedron,
    "octahedron": octahedron,
    "torus": torus,
    "disc": disc,
    "annulus": annulus,
}
EULER = {"tetrahedron": 2, "octahedron": 2, "torus": 0, "disc": 1, "annulus": 0}


@pytest.fixture(params=SHAPES)
def shape(request):
    return request.param


def two_triangles():
    """The unit square, cut from corner 0 to corner 2."""
    return np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float), np.array([[0, 1, 2], [0, 2, 3]])


def sides(triangles):
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def edges(triangles):
    return np.unique(np.sort(sides(triangles), axis=1), axis=0)


def boundary(triangles):
    count = Counter(map(tuple, np.sort(sides(triangles), axis=1).tolist()))
    return {edge for edge, uses in count.items() if uses == 1}


def euler(triangles):
    return len(np.unique(triangles)) - len(edges(triangles)) + len(triangles)


def irregularity(triangles, corners=(), valence=()):
    """R(M), from nothing but the triangles."""
    degree = np.bincount(edges(triangles).ravel())
    optimal = np.full(len(degree), 6)
    optimal[list({v for edge in boundary(triangles) for v in edge})] = 4
    optimal[list(corners)] = valence
    return int(((degree - optimal)[degree > 0] ** 2).sum())


def angles(points, triangles):
    """All angles, (m, 3)."""
    p = points[triangles]
    u, v = np.roll(p, -1, axis=1) - p, np.roll(p, 1, axis=1) - p
    return np.arctan2(np.linalg.norm(np.cross(u, v), axis=2), (u * v).sum(axis=2))


def assert_sound(editor):
    """A fresh editor accepts the frozen mesh as an oriented manifold and finds the same connectivity."""
    now = editor.freeze()
    again = MeshEditor(
        now.points,
        now.triangles,
        crease_edges=now.crease_edges,
        crease_sharpness=now.crease_sharpness,
        corners=now.corners,
        corner_sharpness=now.corner_sharpness,
    )
    n, h = len(now.points), 3 * len(now.triangles)
    np.testing.assert_array_equal(editor._twin[:h], again._twin)
    np.testing.assert_array_equal(editor._sharp[:h], again._sharp)
    np.testing.assert_array_equal(editor._degree[:n], again._degree)
    leaving = editor._out[:n]
    used = leaving >= 0
    assert (editor._origin[leaving[used]] == np.flatnonzero(used)).all()
    assert ((editor._twin[leaving] < 0) == (again._twin[again._out] < 0))[used].all()
    _, uv, _ = editor.carried()
    assert (uv >= 0).all()
    assert (uv.sum(axis=1) <= 1).all()


def scatter(editor, count, seed):
    """Carry random points, some of them on edges and corners, and return their places."""
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(3), count)
    weights[: count // 4, rng.integers(3)] = 0
    weights[: count // 8, 1] = 0
    weights /= weights.sum(axis=1, keepdims=True)
    uv = np.minimum(weights[:, 1:], 1)
    uv[:, 1] = np.minimum(uv[:, 1], 1 - uv[:, 0])
    editor.carry(rng.integers(len(editor.triangles), size=count), uv)
    return places(editor)


def places(editor):
    face, uv, _ = editor.carried()
    p = editor.points[editor.triangles[face]]
    u, v = uv.T[:, :, None]
    return (1 - u - v) * p[:, 0] + u * p[:, 1] + v * p[:, 2]


def test_splitting_all_faces_is_one_refinement(shape):
    points, triangles = SHAPES[shape]()
    editor = MeshEditor(points, triangles)
    split = editor.split_faces(np.ones(len(triangles), bool))
    assert len(editor.triangles) == 4 * len(triangles)
    assert len(split.ends) == len(edges(triangles))
    np.testing.assert_array_equal(split.affected, np.arange(len(points)))
    # Valences: old vertices keep theirs, new ones have 6, or 4 on the boundary.
    degree = np.bincount(edges(editor.triangles).ravel())
    np.testing.assert_array_equal(degree[: len(points)], np.bincount(edges(triangles).ravel()))
    rim = {v for edge in boundary(editor.triangles) for v in edge}
    assert all(degree[v] == (4 if v in rim else 6) for v in split.vertices)
    assert_sound(editor)


def test_split_record_names_the_halved_edges(shape):
    points, triangles = SHAPES[shape]()
    editor = MeshEditor(points, triangles)
    mask = np.zeros(len(triangles), bool)
    mask[[0, len(triangles) // 2]] = True
    split = editor.split_faces(mask)
    np.testing.assert_array_equal(sides(triangles)[split.half_edges], split.ends)
    np.testing.assert_allclose(editor.points[split.vertices], points[split.ends].mean(axis=1), atol=1e-15)
    halved = set(map(tuple, np.sort(split.ends, axis=1).tolist()))
    count = np.array([[tuple(sorted(s)) in halved for s in sides(t[None]).tolist()] for t in triangles]).sum(1)
    assert set(count.tolist()) <= {0, 1, 3}
    assert (count[mask] == 3).all()
    np.testing.assert_array_equal(split.affected, np.unique(triangles[count == 3]))
    frozen = editor.freeze()
    np.testing.assert_array_equal(frozen.parents[split.vertices], split.ends)
    np.testing.assert_array_equal(frozen.parents[: split.first], np.arange(len(points)).repeat(2).reshape(-1, 2))
    np.testing.assert_array_equal(frozen.points[: split.first], points)


def test_one_face_and_its_three_neighbours():
    """The basic case of Nishiyama et al. 2008, Figure 3 (a)."""
    points, triangles = torus()
    editor = MeshEditor(points, triangles)
    editor.split_faces(np.arange(len(triangles)) == 20)
    assert len(editor.points) == len(points) + 3
    assert len(editor.triangles) == len(triangles) + 3 + 3
    assert_sound(editor)


def test_a_face_between_two_split_faces_is_split_in_four():
    """The special case of Nishiyama et al. 2008, Figure 3 (b)."""
    points, triangles = torus()
    between = 20
    neighbours = [
        f for f in range(len(triangles)) if len(set(triangles[f]) & set(triangles[between])) == 2 and f != between
    ]
    editor = MeshEditor(points, triangles)
    split = editor.split_faces(np.isin(np.arange(len(triangles)), neighbours[:2]))
    assert set(triangles[between]) <= set(split.affected.tolist())
    # Three faces in a row have 3 + 2 + 2 edges and touch five others.
    assert len(split.ends) == 7
    assert len(editor.triangles) == len(triangles) + 3 * 3 + 5


@pytest.mark.parametrize("marked", range(8))
@pytest.mark.parametrize("stretch", [0.3, 3.0])
def test_split_edges_of_one_triangle(marked, stretch):
    points = np.array([[0, 0, 0], [1, 0, 0], [0.2, stretch, 0]])
    chosen = np.array([[marked & 1, marked & 2, marked & 4]], bool)
    editor = MeshEditor(points, [[0, 1, 2]])
    before = scatter(editor, 500, 1)
    editor.split_edges(chosen)
    assert len(editor.triangles) == 1 + chosen.sum()
    p = editor.points[editor.triangles]
    areas = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] / 2
    assert (areas > 0).all()
    assert areas.sum() == pytest.approx(stretch / 2)
    np.testing.assert_allclose(places(editor), before, atol=1e-14)
    assert_sound(editor)


def test_split_edges_takes_pairs_in_either_direction():
    points, triangles = disc()
    rim = np.array(sorted(boundary(triangles)))
    rim[::2] = rim[::2, ::-1]
    editor = MeshEditor(points, triangles)
    editor.split_edges(rim)
    assert len(boundary(editor.triangles)) == 2 * len(rim)
    assert euler(editor.triangles) == 1
    assert_sound(editor)


def test_points_stay_in_place_through_splits(shape):
    editor = MeshEditor(*SHAPES[shape]())
    before = scatter(editor, 3000, 2)
    rng = np.random.default_rng(3)
    for _ in range(4):
        editor.split_faces(rng.random(len(editor.triangles)) < 0.15)
        editor.split_edges(rng.random((len(editor.triangles), 3)) < 0.1)
    np.testing.assert_allclose(places(editor), before, atol=1e-14 * np.ptp(before))
    assert not editor.carried()[2].any()
    assert_sound(editor)


def collared_square():
    """The unit square cut from corner 0 to corner 2, and a triangle on each of its sides."""
    points, triangles = two_triangles()
    points = np.vstack([points, [[0.5, -1, 0], [2, 0.5, 0], [0.5, 2, 0], [-1, 0.5, 0]]])
    return points, np.vstack([triangles, [[0, 4, 1], [1, 5, 2], [2, 6, 3], [3, 7, 0]]])


def test_flip_of_a_parallelogram_leaves_points_in_place():
    """There the map to the unit square is affine, so that the two diagonals agree in the plane."""
    points, fan = collared_square()
    for turn in range(3):
        editor = MeshEditor(points @ [[1, 0, 0.2], [0.4, 1, 0], [0, 0, 1]], np.roll(fan, turn, axis=1))
        before = scatter(editor, 400, 4)
        face = editor.carried()[0]
        assert editor.flip([[2, 0]]).tolist() == [True]
        np.testing.assert_allclose(places(editor), before, atol=1e-14)
        np.testing.assert_array_equal(editor.carried()[2], face < 2)
        assert editor.flip([[1, 3]]).tolist() == [True]
        np.testing.assert_allclose(places(editor), before, atol=1e-14)
        assert set(map(frozenset, editor.triangles.tolist())) == set(map(frozenset, fan.tolist()))
        assert_sound(editor)


def test_flip_refusals():
    points, triangles = disc()
    rim = np.array(sorted(boundary(triangles)))
    assert not MeshEditor(points, triangles).flip(rim).any()
    inner = np.array([e for e in edges(triangles).tolist() if tuple(e) not in boundary(triangles)])
    assert not MeshEditor(points, triangles, crease_edges=inner).flip(inner).any()
    # In a tetrahedron the opposite corners are joined already.
    points, triangles = tetrahedron()
    assert not MeshEditor(points, triangles).flip(edges(triangles)).any()
    # Vertices that share no edge.
    assert not MeshEditor(*octahedron()).flip([[0, 3]]).any()
    # A vertex with three edges keeps them.
    points, triangles = tetrahedron()
    editor = MeshEditor(
        np.vstack([points, points[[0, 1, 3]].mean(axis=0)]), [[0, 1, 4], [1, 3, 4], [3, 0, 4], *triangles[1:]]
    )
    assert not editor.flip([[4, 0], [1, 4], [3, 4]]).any()
    # The corner of a square would be left with one triangle.
    assert not MeshEditor(*two_triangles()).flip([[0, 2]]).any()


def test_no_flip_turns_a_triangle_over():
    """Vertex 4 lies behind the edge 0-2's neighbours, so that the quad about 0-2 is not convex."""
    rim = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float)
    points = np.vstack([rim, [[3.5, 3.0, 0], [3.0, 3.5, 0]]])
    triangles = np.array([[0, 1, 4], [1, 2, 4], [2, 5, 4], [2, 3, 5], [3, 0, 5], [0, 4, 5]])
    editor = MeshEditor(points, triangles)
    flipped = editor.flip(edges(triangles))
    p = editor.points[editor.triangles]
    assert (np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] > 0).all()
    assert flipped.any()
    # Corner 0 on the line from 1 to 3 would make a triangle without area.
    points, triangles = collared_square()
    assert MeshEditor(points, triangles).flip([[0, 2]]).all()
    points[0] = points[[1, 3]].mean(axis=0)
    assert not MeshEditor(points, triangles).flip([[0, 2]]).any()
    # Folded by a right angle along 0-2: allowed or not as the threshold says.
    points, triangles = octahedron()
    assert not MeshEditor(points, triangles, max_turn=20).flip(edges(triangles)).any()
    assert MeshEditor(points, triangles, max_turn=80).flip(edges(triangles)).any()


def test_a_sector_between_creases_keeps_two_triangles():
    points, triangles = disc()
    # Round vertex 24 lie 25, 32, 31, 23, 16, 17; its edge to 32 would turn to 25-31.
    across, wider = [[24, 25], [24, 31]], [[24, 25], [24, 23]]
    assert MeshEditor(points, triangles).flip([[24, 32]]).all()
    assert MeshEditor(points, triangles, crease_edges=wider).flip([[24, 32]]).all()
    for edge in ([24, 32], [32, 24]):
        assert not MeshEditor(points, triangles, crease_edges=across).flip([edge]).any()


def shaken(shape, flips=200, seed=5):
    """A refined shape whose connectivity was spoiled by random flips."""
    editor = MeshEditor(*SHAPES[shape]())
    while len(editor.triangles) < 300:
        editor.split_faces(np.ones(len(editor.triangles), bool))
    rng = np.random.default_rng(seed)
    pairs = edges(editor.triangles)
    editor.flip(pairs[rng.integers(len(pairs), size=flips)])
    return editor


def test_regularising_lowers_the_valence_defects(shape):
    editor = shaken(shape)
    scatter(editor, 500, 6)
    before = irregularity(editor.triangles)
    assert editor.irregularity() == before
    previous = before
    while editor.regularise_connectivity(max_sweeps=1):
        now = irregularity(editor.triangles)
        assert now < previous
        assert editor.irregularity() == now
        previous = now
    assert previous < 0.5 * before
    assert euler(editor.triangles) == EULER[shape]
    # A call without a bound on the sweeps ends where no further flip pays.
    again = shaken(shape)
    again.regularise_connectivity()
    assert again.regularise_connectivity() == 0
    again.improve_angles()
    assert again.improve_angles() == 0
    assert_sound(editor)


def test_corners_aim_at_the_valence_they_were_given():
    points, triangles = disc()
    corners = [0, 6, 42, 48]
    editor = MeshEditor(points, triangles, corners=corners)
    given = np.bincount(edges(triangles).ravel())[corners]
    assert editor.irregularity() == irregularity(triangles, corners, given) == 0
    assert editor.regularise_connectivity() == 0


def test_regular_mesh_is_left_alone():
    editor = MeshEditor(*torus())
    assert editor.irregularity() == 0
    assert editor.regularise_connectivity() == 0
    assert not editor.touched().any()


def test_flips_stay_in_the_region():
    """Of two equal bodies the one in the region is edited as if it were alone, the other not at all."""
    one = shaken("torus")
    points, triangles = one.points, one.triangles
    n, m = len(points), len(triangles)
    both = MeshEditor(np.vstack([points, points + 20]), np.vstack([triangles + n, triangles]))
    region = np.arange(2 * n) < n
    scatter(both, 4000, 7)
    face, uv, _ = both.carried()
    for improve in (lambda e, r: e.regularise_connectivity(r), lambda e, r: e.improve_angles(r, max_rise=1)):
        assert improve(both, region) == improve(one, None) > 0
        np.testing.assert_array_equal(both.triangles[:m], triangles + n)
        np.testing.assert_array_equal(both.triangles[m:], one.triangles)
    np.testing.assert_array_equal(both.carried()[0][face < m], face[face < m])
    np.testing.assert_array_equal(both.carried()[1][face < m], uv[face < m])
    assert not both.carried()[2][face < m].any()
    assert not both.touched()[n:].any()


def test_a_region_of_one_vertex_reaches_the_edges_of_its_faces():
    points, triangles = disc()
    for vertex, flips in [(24, 1), (32, 1), (25, 1), (31, 1), (23, 0), (16, 0), (0, 0)]:
        editor = MeshEditor(points, triangles)
        editor.flip([[24, 32]])
        assert editor.regularise_connectivity(np.arange(len(points)) == vertex) == flips
        assert editor.irregularity() == irregularity(editor.triangles)


def test_angle_flips_in_the_plane_reach_delaunay():
    """Lawson 1977: in the plane, edges that may not be improved have empty circumcircles."""
    rng = np.random.default_rng(8)
    points, triangles = disc(12)
    points[:, 2] = 0
    inner = np.ones(len(points), bool)
    inner[list({v for e in boundary(triangles) for v in e})] = False
    points[inner, :2] += rng.uniform(-0.35, 0.35, (inner.sum(), 2))
    editor = MeshEditor(points, triangles)
    smallest = angles(points, editor.triangles).min()
    assert editor.improve_angles() > 0
    assert angles(points, editor.triangles).min() >= smallest
    opposite = {}
    for a, b, c in editor.triangles.tolist():
        opposite.update({(a, b): (a, b, c), (b, c): (b, c, a), (c, a): (c, a, b)})
    checked = 0
    for (a, b), (_, _, c) in opposite.items():
        if inner[a] and inner[b]:
            d = opposite[b, a][2]
            p = points[[a, b, c], :2] - points[d, :2]
            assert np.linalg.det(np.column_stack([p, (p**2).sum(axis=1)])) < 1e-9
            checked += 1
    assert checked > 200
    assert_sound(editor)


def test_angle_flips_may_be_held_to_the_valences(shape):
    editor = shaken(shape)
    editor.regularise_connectivity()
    before = editor.irregularity()
    editor.improve_angles(max_rise=0)
    assert irregularity(editor.triangles) <= before
    assert euler(editor.triangles) == EULER[shape]


def test_creases_and_boundary_stay_the_same_curves():
    points, triangles = annulus()
    ring = np.stack([np.arange(12, 24), np.roll(np.arange(12, 24), -1)], axis=1)
    editor = MeshEditor(points, triangles, crease_edges=ring, crease_sharpness=np.arange(1.0, 13.0), corners=[12])
    length = dict(
        zip(np.arange(1.0, 13.0), np.linalg.norm(points[ring[:, 0]] - points[ring[:, 1]], axis=1), strict=True)
    )
    rim = sum(np.linalg.norm(points[a] - points[b]) for a, b in boundary(triangles))
    rng = np.random.default_rng(9)
    for _ in range(4):
        editor.split_faces(rng.random(len(editor.triangles)) < 0.1)
        editor.split_edges(rng.random((len(editor.triangles), 3)) < 0.05)
        editor.regularise_connectivity()
        editor.improve_angles()
        editor.flip(edges(editor.triangles))
    now = editor.freeze()
    parts = np.linalg.norm(now.points[now.crease_edges[:, 0]] - now.points[now.crease_edges[:, 1]], axis=1)
    for sharpness, whole in length.items():
        assert parts[now.crease_sharpness == sharpness].sum() == pytest.approx(whole)
    assert len(parts) > 24
    # One closed chain still, and the boundary as long as before.
    assert set(np.bincount(now.crease_edges.ravel()).tolist()) == {0, 2}
    assert sum(np.linalg.norm(now.points[a] - now.points[b]) for a, b in boundary(now.triangles)) == pytest.approx(rim)
    assert now.corners.tolist() == [12]
    assert now.corner_sharpness.tolist() == [10.0]
    assert_sound(editor)


def random_edits(editor, seed, rounds=12, largest=4000):
    """Any edits in any order; yields after each."""
    rng = np.random.default_rng(seed)
    for _ in range(rounds):
        region = rng.random(len(editor.points)) < 0.5
        share = 0.15 if len(editor.triangles) < largest else 0.0
        which = rng.integers(5)
        if which == 0:
            editor.split_faces(rng.random(len(editor.triangles)) < share)
        elif which == 1:
            editor.split_edges(rng.random((len(editor.triangles), 3)) < share)
        elif which == 2:
            pairs = edges(editor.triangles)
            editor.flip(pairs[rng.random(len(pairs)) < 0.3])
        elif which == 3:
            editor.regularise_connectivity(region)
        else:
            editor.improve_angles(region, max_rise=2)
        yield which


@pytest.mark.parametrize("seed", range(3))
def test_random_edits_keep_all_invariants(shape, seed):
    points, triangles = SHAPES[shape]()
    creases = edges(triangles)[::7]
    editor = MeshEditor(points, triangles, crease_edges=creases, crease_sharpness=np.linspace(1, 3, len(creases)))
    scatter(editor, 300, seed)
    for _ in random_edits(editor, seed):
        assert euler(editor.triangles) == EULER[shape]
        assert_sound(editor)


def test_the_same_edits_give_the_same_bytes_on_any_number_of_threads():
    results = []
    before = parallel.threads()
    try:
        for count in (1, 4, 4):
            parallel.set_threads(count)
            editor = MeshEditor(*torus())
            scatter(editor, 200_000, 10)
            for _ in random_edits(editor, 11):
                pass
            now = editor.freeze()
            results.append([a.tobytes() for a in (now.points, now.triangles, *editor.carried())])
    finally:
        parallel.set_threads(before)
    assert results[0] == results[1] == results[2]


def test_edits_of_an_open_model_with_creases(meshes):
    model = trimesh.load(meshes / "holes.ply", process=False)
    triangles = np.asarray(model.faces)
    creases = np.asarray(model.face_adjacency_edges)[model.face_adjacency_angles > 0.7]
    editor = MeshEditor(model.vertices, triangles, crease_edges=creases)
    before = scatter(editor, 20_000, 12)
    rng = np.random.default_rng(13)
    editor.split_faces(rng.random(len(triangles)) < 0.1)
    np.testing.assert_allclose(places(editor), before, atol=1e-14 * np.ptp(before))
    defects = editor.irregularity()
    assert editor.regularise_connectivity() > 0
    assert editor.irregularity() < defects
    assert editor.improve_angles(max_rise=0) > 0
    assert euler(editor.triangles) == euler(triangles)
    assert_sound(editor)
    # Flips within a mesh of small dihedral angles leave carried points close by.
    moved = np.linalg.norm(places(editor) - before, axis=1)
    assert np.median(moved) < 1e-3 * np.ptp(before)


def test_touched_since_the_mark():
    points, triangles = torus()
    editor = MeshEditor(points, triangles)
    split = editor.split_faces(np.arange(len(triangles)) == 20)
    touched = editor.touched()
    assert touched[split.vertices].all()
    assert touched[triangles[20]].all()
    # Three corners, three opposite corners, three midpoints.
    assert touched.sum() == 9
    editor.mark()
    assert not editor.touched().any()


def test_the_input_is_not_written_to_and_a_frozen_mesh_stays():
    points, triangles = octahedron()
    kept = points.copy(), triangles.copy()
    editor = MeshEditor(points, triangles)
    frozen = editor.freeze()
    editor.split_faces(np.ones(8, bool))
    editor.place([0], [[9.0, 9, 9]])
    assert editor.points[0].tolist() == [9, 9, 9]
    np.testing.assert_array_equal(points, kept[0])
    np.testing.assert_array_equal(triangles, kept[1])
    np.testing.assert_array_equal(frozen.points, kept[0])
    np.testing.assert_array_equal(frozen.triangles, kept[1])


@pytest.mark.parametrize(
    ("triangles", "tags", "message"),
    [
        ([[0, 1, 2], [0, 1, 3]], {}, "runs the same way"),
        ([[0, 1, 2], [2, 1, 0]], {}, "same corners"),
        ([[0, 1, 1]], {}, "repeats a vertex"),
        ([[0, 1, 9]], {}, "names vertex 9"),
        ([[0, 1, 2], [0, 3, 4]], {}, "separate fans"),
        (np.empty((0, 3), int), {}, "no triangles"),
        ([[0, 1]], {}, "integers"),
        ([[0, 1, 2]], {"crease_edges": [[0, 3]]}, "no edge"),
        ([[0, 1, 2]], {"crease_edges": [[0, 1]], "crease_sharpness": [-1.0]}, "above 0"),
        ([[0, 1, 2]], {"corners": [7]}, "names vertex 7"),
    ],
)
def test_unusable_meshes_are_refused(triangles, tags, message):
    with pytest.raises(InputError, match=message):
        MeshEditor(np.random.default_rng(0).random((5, 3)), triangles, **tags)


def test_unusable_requests_are_refused():
    editor = MeshEditor(*octahedron())
    with pytest.raises(InputError, match="mask of faces"):
        editor.split_faces([True])
    with pytest.raises(InputError, match="mask of sides"):
        editor.split_edges([True])
    with pytest.raises(InputError, match="no edge"):
        editor.split_edges([[0, 3]])
    with pytest.raises(InputError, match="names vertex 6"):
        editor.flip([[0, 6]])
    with pytest.raises(InputError, match="region"):
        editor.regularise_connectivity(np.ones(3, bool))
    with pytest.raises(InputError, match="names face 8"):
        editor.carry([8], [[0, 0]])
    with pytest.raises(InputError, match="give"):
        editor.carry([0], [0.0])
    with pytest.raises(InputError, match="finite"):
        MeshEditor([[0, 0, np.nan]], [[0, 0, 0]])

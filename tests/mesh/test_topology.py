"""Half-edges over ragged faces: what holds for every mesh, and what is refused, with its place."""

import subprocess
import sys

import meshio
import numpy as np
import pytest

from shapes.zoo import ZOO, fan_faces, grid_data, mesh_of
from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology

CUBE = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def polygons(faces, vertex_count, **tags):
    offsets = np.cumsum([0, *(len(face) for face in faces)])
    return Topology.from_faces(offsets, np.concatenate(faces), vertex_count, **tags)


def cube():
    return polygons(CUBE, 8)


def prism():
    """Seven sides: two heptagons and quads, one of them cut in triangles."""
    n = 7
    faces = [list(range(n))[::-1], list(range(n, 2 * n))]
    faces += [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(1, n)]
    return polygons([*faces, [0, 1, n + 1], [0, n + 1, n]], 2 * n)


def open_ragged():
    """A quad, a pentagon and a triangle round one vertex, open."""
    return polygons([[0, 1, 2, 3], [0, 3, 4, 5, 6], [0, 6, 7]], 8)


SHAPES = {name: (lambda name=name: mesh_of(name).topology) for name in ZOO}
SHAPES |= {"cube": cube, "prism": prism, "open ragged": open_ragged}


@pytest.fixture(params=SHAPES, ids=lambda name: name.replace(" ", "_"))
def topology(request):
    return SHAPES[request.param]()


def test_half_edges_run_round_their_faces(topology):
    t = topology
    for f in range(t.face_count):
        first, last = t.face_offsets[f], t.face_offsets[f + 1]
        assert (t.face[first:last] == f).all()
        np.testing.assert_array_equal(t.following[first:last], [*range(first + 1, last), first])


def test_twin_is_an_involution_that_runs_the_other_way(topology):
    t = topology
    h = np.flatnonzero(t.twin >= 0)
    np.testing.assert_array_equal(t.twin[t.twin[h]], h)
    assert (t.twin[h] != h).all()
    np.testing.assert_array_equal(t.face_vertices[t.twin[h]], t.face_vertices[t.following[h]])
    np.testing.assert_array_equal(t.face_vertices[t.following[t.twin[h]]], t.face_vertices[h])


def test_edges_are_numbered_as_half_edges_first_meet_them(topology):
    t = topology
    inner = t.twin >= 0
    np.testing.assert_array_equal(t.edge[t.twin[inner]], t.edge[inner])
    numbers, first = np.unique(t.edge, return_index=True)
    np.testing.assert_array_equal(numbers, np.arange(t.edge_count))
    assert (np.diff(first) > 0).all()
    np.testing.assert_array_equal(t.edge_vertices[:, 0], t.face_vertices[first])
    np.testing.assert_array_equal(t.edge_vertices[:, 1], t.face_vertices[t.following[first]])
    sides = np.bincount(t.edge, minlength=t.edge_count)
    np.testing.assert_array_equal(t.boundary_edges, sides == 1)
    assert len(np.unique(np.sort(t.edge_vertices, axis=1), axis=0)) == t.edge_count


def test_outgoing_leaves_its_vertex_and_begins_the_fan_on_a_boundary(topology):
    t = topology
    np.testing.assert_array_equal(t.face_vertices[t.outgoing], np.arange(t.vertex_count))
    np.testing.assert_array_equal(t.valence, np.bincount(t.face_vertices, minlength=t.vertex_count))
    boundary = np.zeros(t.vertex_count, bool)
    boundary[t.edge_vertices[t.boundary_edges]] = True
    np.testing.assert_array_equal(t.boundary_vertices, boundary)
    np.testing.assert_array_equal(t.twin[t.outgoing] < 0, boundary)
    before = np.empty_like(t.following)
    before[t.following] = np.arange(len(before))
    for v in range(t.vertex_count):
        h, seen = t.outgoing[v], 0
        while True:
            seen += 1
            h = t.twin[before[h]]
            if h < 0 or h == t.outgoing[v]:
                break
        assert seen == t.valence[v]
        assert (h < 0) == boundary[v]


def test_boundary_is_sharp_for_ever_and_creases_are_inside(topology):
    t = topology
    assert np.isinf(t.sharpness[t.boundary_edges]).all()
    assert not t.boundary_edges[t.crease_edges].any()
    assert (t.sharpness[t.crease_edges] > 0).all()


def test_counts_of_ragged_meshes():
    t = prism()
    assert (t.vertex_count, t.edge_count, t.face_count) == (14, 22, 10)
    assert not t.triangles_only
    with pytest.raises(InputError, match="not triangles"):
        _ = t.triangles
    t = open_ragged()
    assert t.boundary_edges.sum() == 8
    assert t.valence.tolist() == [3, 1, 1, 2, 1, 1, 2, 1]


def test_tags_find_their_edges_in_either_direction():
    plain = mesh_of("octahedron").topology
    wanted = plain.edge_vertices[[2, 7]]
    t = Topology.from_triangles(
        plain.triangles, 6, crease_edges=[wanted[0], wanted[1][::-1]], crease_sharpness=[1.5, 10], corner_vertices=[3]
    )
    np.testing.assert_array_equal(np.sort(t.sharpness)[-3:], [0, 1.5, np.inf])
    assert t.sharpness[2] == 1.5
    assert t.sharpness[7] == np.inf
    np.testing.assert_array_equal(t.corner_sharpness, [0, 0, 0, np.inf, 0, 0])
    np.testing.assert_array_equal(t.crease_edges, [2, 7])
    untagged = Topology.from_triangles(plain.triangles, 6, crease_edges=[], corner_vertices=[])
    assert not untagged.sharpness.any()


def test_a_tag_on_the_boundary_changes_nothing():
    t = Topology.from_triangles(fan_faces(4), 5, crease_edges=[[1, 2]], crease_sharpness=[1.0])
    assert np.isinf(t.sharpness[t.boundary_edges]).all()
    assert len(t.crease_edges) == 0


def test_plain_arrays_and_back():
    mesh = mesh_of("tagged sphere 0")
    again = ControlMesh.from_data(mesh.to_data())
    for name in ("face_vertices", "twin", "edge", "sharpness", "corner_sharpness"):
        np.testing.assert_array_equal(getattr(again.topology, name), getattr(mesh.topology, name))
    np.testing.assert_array_equal(again.points, mesh.points)


# What is refused


def refused(match, faces, vertex_count, **tags):
    with pytest.raises(InputError, match=match) as caught:
        polygons(faces, vertex_count, **tags)
    assert "\n" not in str(caught.value)


def test_refuses_a_third_face_on_an_edge():
    refused(r"edge \((0, 1|1, 0)\) has more than two faces", [[0, 1, 2], [1, 0, 3], [0, 1, 4]], 5)
    refused(r"edge \((0, 1|1, 0)\) has more than two faces", [[0, 1, 2], [1, 0, 3], [1, 0, 4]], 5)


def test_refuses_faces_that_disagree_in_orientation():
    refused(r"edge \(1, 2\).*disagree in orientation", [[0, 1, 2], [1, 2, 3]], 4)


def test_refuses_a_face_stored_twice():
    refused(r"edge \(0, 1\)", [[0, 1, 2], [0, 1, 2]], 3)


def test_refuses_a_moebius_strip():
    strip = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [4, 5, 1], [1, 5, 0]]
    refused("disagree in orientation", strip, 6)


@pytest.mark.parametrize("closed", [False, True])
def test_refuses_fans_that_share_a_vertex_only(closed):
    if closed:
        tetrahedron = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
        other = np.where(tetrahedron > 0, tetrahedron + 3, 0)
        refused("vertex 0 joins separate fans", [*tetrahedron, *other], 7)
    else:
        refused("vertex 2 joins separate fans", [[0, 1, 2], [2, 3, 4]], 5)
    refused("vertex 1 joins separate fans", [[0, 1, 2], [3, 1, 4], [5, 1, 6]], 7)


def test_refuses_a_vertex_without_faces():
    refused("vertex 3 belongs to no face", [[0, 1, 2]], 4)


@pytest.mark.parametrize("index", [3, 99, -1, 2**32 + 2])
def test_refuses_an_index_out_of_range(index):
    refused(r"outside 0\.\.2", [[0, 1, index]], 3)


def test_refuses_an_index_that_is_no_whole_number():
    with pytest.raises(InputError, match="face"):
        Topology.from_triangles([[0, 1, 2.5]], 3)


@pytest.mark.parametrize("faces", [[[0, 0, 1]], [[0, 1, 1]], [[1, 0, 1]], [[0, 1, 2], [2, 1, 1]]])
def test_refuses_a_face_that_repeats_a_vertex(faces):
    refused(r"face \d", faces, int(np.concatenate(faces).max()) + 1)


def test_refuses_a_face_that_folds_back_on_itself():
    """A polygon that runs along an edge and back is no face, though its half-edges pair."""
    refused("face 0", [[0, 1, 2, 1]], 3)


@pytest.mark.parametrize("faces", [[[0, 1]], [[0, 1, 2], [1, 0]]])
def test_refuses_a_face_of_two_corners(faces):
    refused(r"face \d", faces, int(np.concatenate(faces).max()) + 1)


BAD_OFFSETS = """
from subdfit.errors import InputError
from subdfit.mesh.topology import Topology
for offsets in ([0, 3, 5], [0, 3], [1, 4, 6], [0, 4, 3, 6], [0, 3, 9], [0, 3, 3, 6], [0, -1, 6], []):
    try:
        Topology.from_faces(offsets, [0, 1, 2, 2, 1, 3], 4)
    except InputError as error:
        assert "face" in str(error) and "edge" not in str(error), (offsets, error)
    else:
        raise AssertionError(offsets)
"""


def test_refuses_offsets_that_do_not_fit_the_faces():
    """In a process of its own: kernels that walk wild offsets may end it."""
    done = subprocess.run([sys.executable, "-c", BAD_OFFSETS], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr or f"the process died of signal {-done.returncode}"


def test_refuses_a_crease_that_is_no_edge():
    t = mesh_of("octahedron").topology
    for pair in ([0, 3], [2, 2], [0, 17], [0, 8], [-1, 2]):
        with pytest.raises(InputError, match=rf"crease \({pair[0]}, {pair[1]}\) is not an edge"):
            Topology.from_triangles(t.triangles, 6, crease_edges=[pair])


@pytest.mark.parametrize("vertex", [6, -1])
def test_refuses_a_corner_that_is_no_vertex(vertex):
    t = mesh_of("octahedron").topology
    with pytest.raises(InputError, match=f"{vertex}"):
        Topology.from_triangles(t.triangles, 6, corner_vertices=[vertex])


@pytest.mark.parametrize("sharpness", [[-1.0], [np.nan], [1.0, 2.0]])
def test_refuses_sharpness_that_is_negative_missing_or_no_number(sharpness):
    triangles = mesh_of("octahedron").topology.triangles
    with pytest.raises(InputError, match="sharpness"):
        Topology.from_triangles(triangles, 6, crease_edges=[[0, 1]], crease_sharpness=sharpness)
    with pytest.raises(InputError, match="sharpness"):
        Topology.from_triangles(triangles, 6, corner_vertices=[0], corner_sharpness=sharpness)


def test_refuses_positions_that_do_not_fit():
    with pytest.raises(InputError, match="positions for 6 vertices"):
        ControlMesh(mesh_of("octahedron").topology, np.zeros((5, 3)))


def test_broken_files_are_refused_in_place(meshes):
    """Meshes that no half-edge structure can hold, as they come from files."""
    for name, text in [
        ("nonmanifold_edge", "edge"),
        ("nonmanifold_vertex", "separate fans"),
        ("isolated_vertices", "belongs to no face"),
        ("inconsistent_orientation", "disagree in orientation"),
        ("duplicate_face", "edge"),
        ("moebius", "disagree in orientation"),
    ]:
        mesh = meshio.read(meshes / "broken" / f"{name}.ply")
        with pytest.raises(InputError, match=text):
            ControlMesh.from_triangles(mesh.points, mesh.cells_dict["triangle"])


def test_large_grid_numbers_every_edge_once():
    _, faces = grid_data(60, 40)
    t = Topology.from_triangles(faces, 61 * 41)
    assert t.edge_count == 60 * 41 + 61 * 40 + 60 * 40
    assert t.boundary_edges.sum() == 2 * (60 + 40)

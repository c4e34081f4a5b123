"""Corners wider than a straight angle: creases part them, so that surfaces do not fold over to the other side."""

import numpy as np
import pytest
import trimesh

import subdfit
from subdfit.fit.settings import FitSettings
from subdfit.fit.starts import started
from subdfit.initial.wide_corners import part_wide_corners
from subdfit.limit.surface import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.frame import Frame
from subdfit.target.target import mesh_target

CORNERS = [[0, 0, 0], [4, 0, 0], [4, 1, 0], [1, 1, 0], [1, 4, 0], [0, 4, 0]]
REFLEX = 3
FAN = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]
QUADS = [[0, 1, 2, 3], [0, 3, 4, 5]]
THREE = [[0, 6, 3, 7], [6, 1, 2, 3], [7, 3, 4, 5]]
"""Quads whose edges from the reflex corner lead to the middles of straight sides."""


def sheet(faces, points=CORNERS):
    """An L in the plane, its six corners tagged."""
    offsets = np.cumsum([0, *map(len, faces)])
    topology = Topology.from_faces(offsets, np.concatenate(faces), len(points), corner_vertices=np.arange(6))
    return ControlMesh(topology, np.array(points, float))


def outside(mesh, scheme):
    """How far the limit surface leaves the L for the side of its reflex corner, at most."""
    surface = LimitSurface(mesh, scheme)
    grid = lattice(surface.domain, 16)
    x, y, z = surface.evaluate(grid.face, grid.uv).position.T
    assert np.abs(z).max() < 1e-12
    return np.minimum(x - 1, y - 1).max()


def creases(mesh):
    t = mesh.topology
    return {frozenset(ends) for ends in t.edge_vertices[t.crease_edges].tolist()}


@pytest.mark.parametrize(
    ("scheme", "faces"),
    [
        ("loop", FAN),
        *((scheme, faces) for scheme in ("catmull-clark", "doo-sabin", "quad-triangle") for faces in (FAN, QUADS)),
    ],
)
def test_a_crease_within_keeps_the_surface_on_its_side(scheme, faces) -> None:
    mesh = sheet(faces)
    assert outside(mesh, scheme) > 0.01
    parted, within = part_wide_corners(mesh)
    assert within.tolist() == [[REFLEX, 0]]
    assert creases(parted) == {frozenset((0, REFLEX))}
    assert outside(parted, scheme) < 1e-9


def test_an_edge_that_leads_to_a_smooth_place_of_a_curve_is_cut() -> None:
    mesh = sheet(THREE, [*CORNERS, [1, 0, 0], [0, 1, 0]])
    parted, within = part_wide_corners(mesh)
    assert within.tolist() == [[REFLEX, 8]]
    assert len(parted.points) == len(mesh.points) + 1
    assert creases(parted) == {frozenset((REFLEX, 8))}
    assert parted.points[8] in np.array([[1, 0.5, 0], [0.5, 1, 0]])
    assert parted.topology.face_count == len(THREE) + 2
    assert outside(parted, "catmull-clark") < 1e-9


@pytest.mark.parametrize("corners", [True, False])
def test_other_meshes_stay_what_they_are(corners) -> None:
    """A box has no such corner, and the L none whose corners are not tagged: its boundary is smooth there."""
    box = trimesh.creation.box()
    mesh = ControlMesh.from_triangles(box.vertices, box.faces, crease_edges=box.face_adjacency_edges)
    if not corners:
        mesh = ControlMesh.from_triangles(CORNERS, FAN)
    parted, within = part_wide_corners(mesh)
    assert parted is mesh
    assert len(within) == 0


def test_corners_that_are_to_stay_whole_are_not_parted() -> None:
    mesh = sheet(FAN)
    assert part_wide_corners(mesh, [REFLEX])[0] is mesh


def sawn_tube(around=32, rows=6):
    """A tube of triangles, wider in its middle; its upper rim is a zigzag along their edges."""
    row, k = np.divmod(np.arange(around * (rows + 1)), around)
    turn, radius = 2 * np.pi * (k + row / 2) / around, 1 + 0.2 * np.sin(np.pi * row / rows)
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), row * np.pi * np.sqrt(3) / around])
    at = np.arange(around * (rows + 1)).reshape(rows + 1, around)
    here, beside, above = at[:-1], np.roll(at[:-1], -1, axis=1), at[1:]
    across = np.stack([beside, np.roll(above, -1, axis=1), above], axis=2)[:-1]
    return points, np.concatenate([np.stack([here, beside, above], axis=2).reshape(-1, 3), across.reshape(-1, 3)])


@pytest.mark.parametrize("around", [16, 24, 32])
def test_notches_of_a_zigzag_are_not_parted(around) -> None:
    whole = mesh_target(*sawn_tube(around))
    target = whole.normalised(Frame.of(whole.points))
    settings = FitSettings(scheme="quad-triangle", method="lavoue", tolerance=Tolerance(max=0.01))
    found, mesh = started(target, settings)
    assert len(part_wide_corners(mesh)[1]) > 0
    assert len(found.within) == len(mesh.topology.crease_edges) == 0


def test_a_tube_with_a_sawn_rim_is_certified() -> None:
    found = subdfit.fit(sawn_tube(), scheme="catmull-clark", method="lavoue", max_error="1%")
    assert found.certified


def angle():
    """The L as a plate of thickness 1: its triangles cut until their sides are .5 at most."""
    low, fan = np.array(CORNERS, float), np.array(FAN)
    a, b = np.arange(6), np.roll(np.arange(6), -1)
    walls = [np.column_stack([a, b, b + 6]), np.column_stack([a, b + 6, a + 6])]
    faces = np.concatenate([fan[:, ::-1], fan + 6, *walls])
    return trimesh.remesh.subdivide_to_size(np.concatenate([low, low + np.array([0, 0, 1])]), faces, 0.5)


@pytest.mark.parametrize(
    ("scheme", "method"),
    [*((scheme, "auto") for scheme in ("loop", "catmull-clark", "quad-triangle", "doo-sabin")),
     ("quad-triangle", "lavoue"), ("catmull-clark", "lavoue")],
)  # fmt: skip
def test_an_angle_takes_few_control_vertices(scheme, method) -> None:
    found = subdfit.fit(angle(), scheme=scheme, method=method, max_error="0.5%")
    assert found.certified
    assert len(found.control_mesh.points) <= 24

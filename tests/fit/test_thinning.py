"""Lighter control meshes: what is too many is taken out, and what was asked goes on to hold."""

import numpy as np
import pytest
import trimesh

import subdfit
from shapes import grids
from shapes.zoo import euler, mesh_of
from subdfit.fit.data import FitData
from subdfit.fit.reverse import strays
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FitState
from subdfit.fit.thinning import Thinning
from subdfit.fit.thinning_batches import MANY, Batches
from subdfit.fit.thinning_changes import collapses
from subdfit.fit.thinning_hold import Hold
from subdfit.fit.thinning_queue import Queue
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.polygon_edits import PolygonEdits
from subdfit.target.frame import Frame
from subdfit.target.target import mesh_target


def icosahedral(scheme: str, level: int, settings: FitSettings) -> FitState:
    """The surface of an icosahedron's twelve vertices by a control mesh refined `level` times, and points on it."""
    coarse = ControlMesh(mesh_of("icosahedron").topology, mesh_of("icosahedron").points, scheme)
    refined = subdfit.subdivide(coarse, level)
    dense = subdfit.subdivide(coarse, level + 2, limit=True)
    target = mesh_target(dense.points, dense.topology.triangles, creases="none")
    frame = Frame.of(target.points)
    data = FitData.of(target.normalised(frame), settings.sample_spacing)
    mesh = ControlMesh(refined.topology, frame.inside(refined.points), scheme)
    return FitState.start(data, LimitSurface(mesh, scheme))


@pytest.mark.parametrize("scheme", ["loop", "quad-triangle"])
def test_a_refined_control_mesh_becomes_nearly_as_light_as_it_was(scheme: str) -> None:
    """The surface of an icosahedron's twelve vertices, from the 42 of one step of subdivision."""
    settings = FitSettings(scheme=scheme, tolerance=Tolerance(max=5e-3))
    begun = icosahedral(scheme, 1, settings)
    found = list(Thinning(settings).lighter(begun))
    counts = [state.surface.topology.vertex_count for state in found]
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] <= 24
    assert all(state.errors.max <= 5e-3 for state in found)
    # Each change was looked at on its own part alone; the whole holds all the same.
    assert all(len(strays(state.surface, begun.data.target, 5e-3)) == 0 for state in found)


@pytest.mark.parametrize("scheme", ["loop", "quad-triangle"])
def test_many_changes_stand_or_are_blamed_together(scheme: str) -> None:
    for bound, some_stand in ((5e-3, True), (1e-9, False)):
        settings = FitSettings(scheme=scheme, tolerance=Tolerance(max=bound))
        state = icosahedral(scheme, 3, settings)
        way, edits = Batches(Hold(settings)), PolygonEdits(state.surface.control_mesh)
        count = state.surface.topology.vertex_count
        changes = way.chosen(state, edits, Queue(collapses, count).cheapest(state.surface, edits))
        assert len(changes) >= MANY
        kept = way.kept(state, changes)
        assert (kept is not None) == some_stand
        if kept is not None:
            left = kept.state.surface.topology.vertex_count
            assert count - len(changes) <= left <= count - len(changes) / 2
            assert kept.state.errors.max <= bound
            assert len(strays(kept.state.surface, state.data.target, bound)) == 0


def test_a_lighter_fit_is_certified_like_any_other() -> None:
    shape = trimesh.creation.torus(1.0, 0.4, 48, 24)
    target = (np.asarray(shape.vertices), np.asarray(shape.faces))
    plain, thin = (subdfit.fit(target, scheme="catmull-clark", max_error="0.5%", thin=thin) for thin in (False, True))
    t = thin.control_mesh.topology
    assert thin.certified
    assert t.vertex_count < plain.control_mesh.topology.vertex_count
    assert euler(t) == 0
    assert thin.history[-1].control_vertices == t.vertex_count


def flat(parts: int) -> tuple[np.ndarray, np.ndarray]:
    """A sheet of 3 by 2 in so many by so many squares, each cut in two."""
    plan = np.stack(np.meshgrid(np.linspace(0, 3, parts + 1), np.linspace(0, 2, parts + 1), indexing="ij"), -1)
    triangles = grids.triangles_of(grids.vertices(parts + 1, parts + 1))
    return np.pad(plan.reshape(-1, 2), ((0, 0), (0, 1))), triangles


@pytest.mark.parametrize("scheme", ["quad-triangle", "catmull-clark"])
@pytest.mark.parametrize("method", ["tangent", "lavoue"])
def test_a_sheet_ends_as_one_face_and_a_box_as_six(scheme: str, method: str) -> None:
    box = trimesh.creation.box((3, 2, 1)).subdivide_to_size(0.3)
    for mesh, vertices, faces in ((flat(12), 4, 1), ((np.asarray(box.vertices), np.asarray(box.faces)), 8, 6)):
        found = subdfit.fit(mesh, scheme=scheme, method=method, thin=True, max_error="0.5%")
        assert found.certified
        topology = found.control_mesh.topology
        assert (topology.vertex_count, topology.face_count) == (vertices, faces)

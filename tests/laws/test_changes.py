"""What moves when a control point moves: no more than the cells that the rule of rings names, for every scheme."""

import numpy as np
import pytest

from shapes.parameters import CASES, finer, inside
from subdfit.fit.changes import cells_moved_by, changed_cells
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.editor import MeshEditor


@pytest.mark.parametrize(("scheme", "name"), CASES)
def test_a_control_point_moves_no_cell_out_of_its_reach(scheme, name):
    surface = finer(scheme, name)
    cell, uv = inside(surface.domain, per_cell=2)
    before = surface.evaluate(cell, uv).position
    for vertex in np.random.default_rng(0).integers(0, surface.topology.vertex_count, 4):
        points = surface.control_mesh.points.copy()
        points[vertex] += [0.1, 0.2, 0.3]
        moved = surface.with_points(points)
        named = changed_cells(surface, moved)
        still = ~named[cell]
        np.testing.assert_array_equal(moved.evaluate(cell[still], uv[still]).position, before[still])
        lone = np.arange(surface.topology.vertex_count) == vertex
        assert np.array_equal(named, cells_moved_by(surface, lone))
    assert not changed_cells(surface, surface.with_points(surface.control_mesh.points)).any()


@pytest.mark.parametrize("edit", ["split", "flip", "crease"])
def test_an_edit_changes_no_cell_out_of_its_reach(edit):
    surface = finer("loop", "icosahedron")
    mesh = surface.control_mesh
    data = mesh.to_data()
    editor = MeshEditor(mesh.points, mesh.topology.triangles, crease_edges=data.crease_edges)
    creases = data.crease_edges
    if edit == "split":
        chosen = np.zeros(mesh.topology.face_count, bool)
        chosen[5] = True
        editor.split_faces(chosen)
    elif edit == "flip":
        assert editor.flip(mesh.topology.edge_vertices[[7]]).all()
    else:
        creases = np.concatenate([np.asarray(creases).reshape(-1, 2), mesh.topology.edge_vertices[[3]]])
    frozen = editor.freeze()
    after = LimitSurface(ControlMesh.from_triangles(frozen.points, frozen.triangles, crease_edges=creases), "loop")
    changed = changed_cells(surface, after)
    assert changed.any()
    assert not changed.all()
    kept = np.flatnonzero(~changed)
    cell, uv = kept.repeat(3), np.tile([[0.2, 0.3], [0.6, 0.1], [0.1, 0.8]], (len(kept), 1))
    ours, theirs = (s.evaluate(cell, uv).position for s in (surface, after))
    np.testing.assert_allclose(ours, theirs, atol=1e-14)
    altered = np.flatnonzero(changed[: surface.domain.face_count])
    cell, uv = altered.repeat(3), np.tile([[0.2, 0.3], [0.6, 0.1], [0.1, 0.8]], (len(altered), 1))
    ours, theirs = (s.evaluate(cell, uv).position for s in (surface, after))
    assert np.abs(ours - theirs).max() > 1e-6

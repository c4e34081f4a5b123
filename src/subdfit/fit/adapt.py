"""Adapting the control mesh to the error: new vertices on the sides of faces, footpoints carried along or found anew.

Triangle meshes go through the editor, polygon meshes through templates that keep quads; which it is the scheme says.
"""

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.places import Places
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.editor import Frozen, MeshEditor, Split
from subdfit.mesh.polygon_refinement import refine_polygons
from subdfit.schemes import Scheme
from subdfit.schemes.domain import TRIANGLE, Domain

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]


def refined(state: FitState, sides: Flags, whole_faces: bool = False, regularise: bool = True) -> FitState:
    """Halve sides of faces.

    Parameters
    ----------
    state
        Where the fit stands.
    sides
        (h,) bool by half-edge of the control mesh.
    whole_faces
        A triangle with two sides halved is cut in four, as one with three is.
    regularise
        Flip edges near new vertices, in triangle meshes.
    """
    if state.surface.scheme.faces == "triangles":
        return _refined_triangles(state, sides, whole_faces, regularise)
    return _refined_polygons(state, sides)


def _refined_triangles(state: FitState, sides: Flags, whole_faces: bool, regularise: bool) -> FitState:
    editor = _open(state)
    editor.mark()
    marks = sides.reshape(-1, 3)
    split = editor.split_faces(marks.all(axis=1)) if whole_faces else editor.split_edges(marks)
    _place_subdivided(editor, split, state)
    if regularise:
        region = editor.touched()
        editor.regularise_connectivity(region)
        editor.improve_angles(region, max_rise=0)
    surface = LimitSurface(_control_mesh(editor.freeze(), state.surface.scheme.name), state.surface.scheme)
    face, uv, _ = editor.carried()
    return state.onto(surface, face, uv)


def _open(state: FitState) -> MeshEditor:
    """Put the control mesh under edit, carrying all footpoints."""
    mesh = state.surface.control_mesh
    data = mesh.to_data()
    editor = MeshEditor(
        mesh.points,
        mesh.topology.triangles,
        crease_edges=data.crease_edges,
        crease_sharpness=data.crease_sharpness,
        corners=data.corner_vertices,
        corner_sharpness=data.corner_sharpness,
    )
    editor.carry(state.face, state.uv)
    return editor


def _place_subdivided(editor: MeshEditor, split: Split, state: FitState) -> None:
    """Give new and affected vertices the positions of one subdivision step, so that the surface barely moves.

    Nishiyama et al. 2008, section 5, after Marinov and Kobbelt 2005.
    """
    topology = state.surface.topology
    refinement = state.surface.scheme.refine(topology)
    positions = refinement.refined(state.surface.control_mesh.points)
    editor.place(split.vertices, positions[refinement.edge_row[topology.edge[split.half_edges]]])
    editor.place(split.affected, positions[refinement.vertex_row[split.affected]])


def _control_mesh(frozen: Frozen, scheme: str) -> ControlMesh:
    """The control mesh of a frozen edit."""
    mesh = ControlMesh.from_triangles(
        frozen.points,
        frozen.triangles,
        crease_edges=frozen.crease_edges,
        crease_sharpness=frozen.crease_sharpness,
        corner_vertices=frozen.corners,
        corner_sharpness=frozen.corner_sharpness,
    )
    return ControlMesh(mesh.topology, mesh.points, scheme)


def _refined_polygons(state: FitState, sides: Flags) -> FitState:
    """Cut faces by templates; footpoints are carried along."""
    coarse, scheme = state.surface, state.surface.scheme
    found = refine_polygons(coarse.control_mesh, sides, polygons=scheme.faces == "polygons")
    places = Places(coarse)
    limits = np.concatenate([places.vertices(), places.middles(found.halved), places.centres(found.centred)])
    points = drawn_near(found.mesh, scheme, limits)
    fine = LimitSurface(ControlMesh(found.mesh.topology, points, scheme.name), scheme)
    return FitState.follow(state.data, fine, *_carried(state, fine, found.parent))


def _carried(state: FitState, fine: LimitSurface, parent: Rows) -> tuple[NDArray[np.int32], Floats]:
    """Where footpoints begin on a refined surface: where they were, or in the nearest cell that is part of their face.

    `parent` (f,) is the face that each finer one is a part of.
    """
    coarse = state.surface
    cell, uv = _kept_cells(coarse, fine, parent)[state.face], state.uv.copy()
    middles = _middles(fine.domain)
    position = fine.evaluate(np.arange(fine.domain.face_count), middles).position
    parts = np.argsort(parent[Places(fine).face], kind="stable")
    count = np.bincount(parent[Places(fine).face], minlength=coarse.topology.face_count)
    begin = np.cumsum(count) - count
    other = np.flatnonzero(cell < 0)
    face = Places(coarse).face[state.face[other]]
    point = np.repeat(other, count[face])
    place = np.arange(len(point)) - np.repeat(np.cumsum(count[face]) - count[face] - begin[face], count[face])
    distance = np.linalg.norm(position[parts[place]] - state.data.points[point], axis=1)
    order = np.lexsort((distance, point))
    nearest = order[np.flatnonzero(np.diff(point[order], prepend=-1))]
    cell[other] = parts[place[nearest]]
    uv[other] = middles[cell[other]]
    return cell.astype(np.int32), uv


def _kept_cells(coarse: LimitSurface, fine: LimitSurface, parent: Rows) -> Rows:
    """The cell of the finer surface that each of the coarse one is, (cells,); -1 in faces that were cut or changed.

    Where cells are whole faces on one and parts of them on the other, none is.
    """
    if coarse.domain.parts != fine.domain.parts:
        return np.full(coarse.domain.face_count, -1)
    old, new = coarse.topology, fine.topology
    child = np.searchsorted(parent, np.arange(old.face_count))
    first, then = old.face_offsets[:-1], new.face_offsets[child]
    kept = np.bincount(parent, minlength=old.face_count) == 1
    kept &= np.diff(old.face_offsets) == np.diff(new.face_offsets)[child]
    kept &= old.face_vertices[first] == new.face_vertices[then]
    cell = np.full(len(new.twin), -1)
    cell[fine.domain.half_edge] = np.arange(fine.domain.face_count)
    half_edge, face = coarse.domain.half_edge, Places(coarse).face
    return np.where(kept[face], cell[np.where(kept[face], half_edge + (then - first)[face], 0)], -1)


def _middles(domain: Domain) -> Floats:
    """Parameters of the middle of each cell, (cells, 2)."""
    middle = np.where(domain.shape == TRIANGLE, 1 / 3, 1 / 2)
    return np.column_stack([middle, middle])


def drawn_near(mesh: ControlMesh, scheme: Scheme, limits: Floats) -> Floats:
    """Control points, (n, 3), whose limit points are drawn near `limits`, by a step of progressive interpolation.

    After it a refined surface has barely moved. More meet the limits ever better by dividing by small eigenvalues of
    the masks: round after round of refining, control points then swing ever farther where coarse meets fine.

    Cheng et al. 2009, section 2.
    """
    return np.asarray(mesh.points + limits - scheme.limit_points(mesh.topology, mesh.points))

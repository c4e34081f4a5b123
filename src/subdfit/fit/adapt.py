"""Adapting the control mesh to the error: insertion of vertices, connectivity, and carrying footpoints along."""

import numpy as np
from numpy.typing import NDArray

from subdfit.fit import _kernels as kernels
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.editor import Frozen, MeshEditor, Split

Floats = NDArray[np.float64]


def open_editor(state: FitState) -> MeshEditor:
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


def place_subdivided(editor: MeshEditor, split: Split, state: FitState) -> None:
    """Give new and affected vertices the positions of one subdivision step, so that the surface barely moves.

    Nishiyama et al. 2008, section 5, after Marinov and Kobbelt 2005.
    """
    topology = state.surface.topology
    refinement = state.surface.scheme.refine(topology)
    positions = refinement.matrix @ state.surface.control_mesh.points
    editor.place(split.vertices, positions[refinement.edge_row[topology.edge[split.half_edges]]])
    editor.place(split.affected, positions[refinement.vertex_row[split.affected]])


def close_editor(editor: MeshEditor, state: FitState) -> FitState:
    """Freeze the edited mesh; footpoints go on from where they were carried."""
    surface = LimitSurface(control_mesh(editor.freeze(), state.surface.scheme.name), state.surface.scheme)
    face, uv, _ = editor.carried()
    return FitState.follow(state.data, surface, face, uv)


def control_mesh(frozen: Frozen, scheme: str) -> ControlMesh:
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


def face_maxima(state: FitState) -> Floats:
    """Largest excess of the points on each face, (f,)."""
    out = np.zeros(state.surface.domain.face_count)
    kernels.group_maximum(state.face, state.excess, out)
    return out


def side_marks(state: FitState, tolerance: float) -> NDArray[np.bool_]:
    """Sides of faces, (f, 3), whose boundary or crease points lie farther from the curve than `tolerance`."""
    marks = np.zeros((state.surface.domain.face_count, 3), np.bool_)
    for found, curves in zip((state.boundary, state.crease), state.curves, strict=True):
        if found is None or curves is None:
            continue
        worst = np.zeros(len(curves))
        np.maximum.at(worst, found.side, found.distance)
        far = np.flatnonzero(worst > tolerance)
        marks[curves.cell[far], curves.side[far]] = True
    return marks


def longest_sides(state: FitState, faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Mark the longest side of each given face, (f, 3)."""
    mesh = state.surface.control_mesh
    corners = state.surface.vertex_limits()[mesh.topology.triangles[faces]]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    marks = np.zeros((mesh.topology.face_count, 3), np.bool_)
    marks[faces, length.argmax(axis=1)] = True
    return marks


def all_sides(state: FitState, faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Mark all sides of the given faces, (f, 3)."""
    marks = np.zeros((state.surface.topology.face_count, 3), np.bool_)
    marks[faces] = True
    return marks


def large_enough(state: FitState, faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Those of the given faces whose longest side exceeds the data's own spacing: finer ones would follow nothing."""
    mesh = state.surface.control_mesh
    corners = mesh.points[mesh.topology.triangles[faces]]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    return np.asarray(faces[length > state.data.spacing])

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

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rows = NDArray[np.int64]

SETTLING = 30
"""Iterations that put the limit points of a refined mesh where the coarse surface had them."""
OVER_RELAXATION = 1.7
"""Nearly 2 / (1 + lambda), lambda = 1/9 being the least eigenvalue of Catmull-Clark's limit masks on regular meshes."""


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
    """Cut faces by templates; all footpoints are found anew."""
    coarse, scheme = state.surface, state.surface.scheme
    found = refine_polygons(coarse.control_mesh, sides, polygons=scheme.faces == "polygons")
    places = Places(coarse)
    limits = np.concatenate([places.vertices(), places.middles(found.halved), places.centres(found.centred)])
    points = settled(found.mesh, scheme, limits)
    mesh = ControlMesh(found.mesh.topology, points, scheme.name)
    return FitState.start(state.data, LimitSurface(mesh, scheme))


def settled(mesh: ControlMesh, scheme: Scheme, limits: Floats) -> Floats:
    """Control points whose limit points lie at (n, 3) `limits`, very nearly: the surface barely moves.

    Progressive interpolation (Cheng et al. 2009), over-relaxed, from the mesh's own points.
    """
    rows = scheme.limit_rows(mesh.topology)
    points = mesh.points
    for _ in range(SETTLING):
        points = points + OVER_RELAXATION * (limits - rows @ points)
    return points

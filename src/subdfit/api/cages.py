"""Control meshes from what callers and files give, and the scheme each is meant for."""

import logging
from dataclasses import replace

import numpy as np

from subdfit.api.sources import MeshSource, source_of
from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData
from subdfit.mesh.repair import check, mend
from subdfit.schemes import SCHEMES

logger = logging.getLogger(__name__)

NONE, EDGE_AND_CORNER = 0, 1
"""OpenSubdiv's boundary rules under which boundary faces only support others, and boundary vertices with a single face
are corners."""


def control_mesh_of(given: ControlMesh | MeshSource, scheme: str | None = None) -> ControlMesh:
    """Return the control mesh of whatever was given, with its scheme's name set.

    A mesh that is a manifold as it is stays as it is, vertex by vertex; another is mended, with warnings.

    Parameters
    ----------
    given
        A control mesh, or see `subdfit.api.sources.MeshSource`.
    scheme
        Overrides what the mesh says, with a warning; None takes that, and where it says nothing Loop for triangles,
        else Catmull-Clark.

    Raises
    ------
    InputError
        No faces, nothing that can be mended, or a scheme that is not there.
    """
    if isinstance(given, ControlMesh):
        mesh, name = given, "control mesh"
    else:
        data, name = source_of(given)
        mesh = _built(data, name)
    chosen = _scheme(mesh, scheme, name)
    return mesh if mesh.scheme == chosen else replace(mesh, scheme=chosen)


def _built(data: MeshData, name: str) -> ControlMesh:
    if data.face_count == 0:
        raise InputError(f"{name}: has points only, a control mesh needs faces; join them first (reconstruct)")
    check(data, name)
    try:
        mesh = ControlMesh.from_data(data)
    except InputError:
        data = mend(data, name=name).data
        mesh = ControlMesh.from_data(data)
    if data.interpolate_boundary == NONE and mesh.topology.boundary_edges.any():
        logger.warning("%s: asks for no rule at its boundary; its boundary edges are taken as sharp", name)
    return _boundary_corners(mesh, data) if data.interpolate_boundary == EDGE_AND_CORNER else mesh


def _boundary_corners(mesh: ControlMesh, data: MeshData) -> ControlMesh:
    """Tag boundary vertices with a single face as corners."""
    topology = mesh.topology
    single = np.flatnonzero(topology.boundary_vertices & (topology.valence == 1))
    sharpness = topology.corner_sharpness.copy()
    sharpness[single] = np.inf
    tagged = np.flatnonzero(sharpness)
    return ControlMesh.from_data(replace(data, corner_vertices=tagged, corner_sharpness=sharpness[tagged]))


def _scheme(mesh: ControlMesh, asked: str | None, name: str) -> str:
    if asked is not None and mesh.scheme not in (None, asked):
        logger.warning("%s: says that its scheme is %s; taken as %s as asked", name, mesh.scheme, asked)
    stated = asked or mesh.scheme
    chosen = stated or ("loop" if mesh.topology.triangles_only else "catmull-clark")
    if chosen not in SCHEMES:
        why = "the scheme asked" if asked else "its scheme" if stated else "it has polygons, and so its scheme"
        raise InputError(f"{name}: {why} is {chosen}, which is not supported; choose one of {', '.join(SCHEMES)}")
    return chosen

"""What callers may pass as a mesh or a cloud of points, turned into plain arrays."""

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.io import read
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData, positions

MeshSource = str | os.PathLike[str] | MeshData | ControlMesh | tuple[ArrayLike, ArrayLike] | ArrayLike | Any
"""A path, `MeshData`, a `ControlMesh`, ``(vertices, faces)``, an array of points, a trimesh or a PyVista object."""


class Source(NamedTuple):
    """Arrays, and what messages call them."""

    data: MeshData
    name: str


def source_of(given: Any) -> Source:
    """Return the arrays of whatever was given.

    Parameters
    ----------
    given
        See `MeshSource`. Objects of trimesh and PyVista are known by their attributes; neither library is imported.
        Faces are (m, k) rows, or a list of lists for polygons of several sizes.

    Raises
    ------
    InputError
        A file that cannot be read, or an object of another kind.
    """
    if isinstance(given, str | os.PathLike):
        path = Path(given)
        return Source(read(path), path.name)
    if isinstance(given, MeshData):
        return Source(given, "mesh")
    if isinstance(given, ControlMesh):
        return Source(given.to_data(), "mesh")
    if hasattr(given, "vertices"):
        return Source(_data(given.vertices, getattr(given, "faces", ())), "mesh")
    if hasattr(given, "points"):
        return Source(_from_pyvista(given), "mesh")
    if isinstance(given, tuple | list) and len(given) == 2 and np.ndim(given[0]) == 2:
        return Source(_data(*given), "mesh")
    if isinstance(given, tuple | list | np.ndarray):
        return Source(_data(given, ()), "points")
    raise InputError(
        f"a target of type {type(given).__name__} is not understood; give a path, (vertices, faces), an array of "
        "points, a trimesh or a PyVista object"
    )


def mesh_data(given: Any) -> MeshData:
    """Return the plain arrays of whatever was given, as `source_of` reads it."""
    return source_of(given).data


def _from_pyvista(given: Any) -> MeshData:
    """Read the padded faces of a PolyData; grids of cells are reduced to their surface first."""
    if not hasattr(given, "faces") and hasattr(given, "extract_surface"):
        given = given.extract_surface()
    if getattr(given, "n_strips", 0):
        given = given.triangulate()
    padded = np.asarray(getattr(given, "faces", ()), np.int64).ravel().tolist()
    faces, at = [], 0
    while at < len(padded):
        faces.append(padded[at + 1 : at + 1 + padded[at]])
        at += 1 + padded[at]
    return _data(given.points, faces)


def _data(vertices: ArrayLike, faces: Any) -> MeshData:
    points = np.array(positions(vertices))
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(f"the vertices have the shape {points.shape}; give one row of three coordinates each")
    sizes, corners = _ragged(faces)
    return MeshData(points, np.concatenate(([0], np.cumsum(sizes))).astype(np.int64), corners)


def _ragged(faces: Any) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sizes and corners of faces given as rows or as a list of lists."""
    rows = [np.asarray(faces)] if isinstance(faces, np.ndarray) else [np.asarray(face) for face in faces]
    if isinstance(faces, np.ndarray):
        if faces.size and faces.ndim != 2:
            raise InputError(f"the faces have the shape {faces.shape}; give one row of vertex numbers a face")
        sizes = np.full(len(faces) if faces.size else 0, faces.shape[-1], np.int64)
    else:
        sizes = np.array([len(row) for row in rows], np.int64)
    corners = np.concatenate([np.empty(0, np.int64), *(row.ravel() for row in rows)])
    whole = corners.astype(np.int64)
    if corners.dtype == np.bool_ or not np.array_equal(whole, corners):
        raise InputError("the faces name vertices by numbers that are no integers; give row numbers from 0")
    return sizes, whole

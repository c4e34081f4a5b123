"""Reading and writing, for callers."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from subdfit import io
from subdfit.api.surface import Tessellation
from subdfit.api.triangulate import triangles_of
from subdfit.errors import InputError
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData

TRIANGLES = (".stl", ".glb")
"""Formats of triangles only."""


def read(path: str | os.PathLike[str]) -> MeshData:
    """Read a mesh or a cloud of points, in the format that the extension names: the file's own numbers, nothing mended.

    Raises
    ------
    InputError
        The file is missing, of an unknown kind, or does not hold what it claims.

    Examples
    --------
    >>> cage = subdfit.read("cage.obj")  # doctest: +SKIP
    >>> subdfit.LimitSurface(cage).tessellate(2)  # doctest: +SKIP
    """
    return io.read(os.fspath(path))


def write(path: str | os.PathLike[str], mesh: ControlMesh | MeshData | Tessellation) -> None:
    """Write a mesh, in the format that the extension names; the file appears whole or not at all.

    Parameters
    ----------
    path
        ``.obj``, ``.ply``, ``.json`` keep scheme, creases and corners; ``.off`` faces only; ``.stl`` and ``.glb``
        triangles, into which polygons are cut.
    mesh
        A control mesh, arrays, or what `LimitSurface.tessellate` gives: of a control mesh its polygons are written, not
        its limit surface.

    Raises
    ------
    InputError
        The extension is unknown, or the format cannot hold this mesh.
    MachineError
        The file cannot be written.
    """
    data = _arrays(mesh)
    if Path(path).suffix.lower() in TRIANGLES and not data.triangles_only:
        triangles = triangles_of(data)
        data = replace(data, face_offsets=3 * np.arange(len(triangles) + 1), face_vertices=triangles.ravel())
    io.write(os.fspath(path), data)


def tessellation_data(tessellation: Tessellation) -> MeshData:
    """A tessellation as plain arrays."""
    triangles = tessellation.triangles.astype(np.int64)
    offsets = 3 * np.arange(len(triangles) + 1)
    return MeshData(tessellation.points, offsets, triangles.ravel(), normals=tessellation.normals)


def _arrays(mesh: ControlMesh | MeshData | Tessellation) -> MeshData:
    if isinstance(mesh, ControlMesh):
        return mesh.to_data()
    if isinstance(mesh, Tessellation):
        return tessellation_data(mesh)
    if isinstance(mesh, MeshData):
        return mesh
    raise InputError(f"cannot write a {type(mesh).__name__}; give a control mesh, MeshData or a tessellation")

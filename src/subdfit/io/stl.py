"""STL: triangles without connectivity. Binary in float32; ASCII is read through trimesh."""

from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.io.library import load
from subdfit.io.tessellation import triangles_of
from subdfit.mesh.data import MeshData

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER = 84
"""Bytes before the triangles; the last four are their number."""


def parse(content: bytes, path: Path) -> MeshData:
    """Read ASCII or binary STL as a triangle soup (three vertices a face); raises InputError."""
    stated = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
    held = max(len(content) - _HEADER, 0) / _RECORD.itemsize
    if len(content) >= _HEADER and stated == held:
        points = np.frombuffer(content, _RECORD, offset=_HEADER)["corners"].reshape(-1, 3).astype(np.float64)
        return MeshData(points, np.arange(0, len(points) + 1, 3), np.arange(len(points)))
    if b"\0" not in content:
        return load(content, path, "stl")
    raise InputError(
        f"{path.name}: the header states {stated:,} triangles, the file holds {held:,.1f}; it is cut or contradictory, "
        "export it again"
    )


def render(data: MeshData, path: Path) -> bytes:
    """Write binary STL with the faces' unit normals; raises InputError unless all faces are triangles."""
    triangles = triangles_of(data, path)
    records = np.zeros(len(triangles), _RECORD)
    corners = data.points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    records["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    records["corners"] = corners
    header = b"subdfit".ljust(_HEADER - 4)
    return header + len(triangles).to_bytes(4, "little") + records.tobytes()

"""STL: triangles without connectivity. Read through trimesh, written as binary, float32."""

from pathlib import Path

import numpy as np

from subdfit.io.library import load
from subdfit.io.tessellation import triangles_of
from subdfit.mesh.data import MeshData

_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def parse(content: bytes, path: Path) -> MeshData:
    """Read ASCII or binary STL as a triangle soup (three vertices a face); raises InputError."""
    return load(content, path, "stl")


def render(data: MeshData, path: Path) -> bytes:
    """Write binary STL with the faces' unit normals; raises InputError unless all faces are triangles."""
    triangles = triangles_of(data, path)
    records = np.zeros(len(triangles), _RECORD)
    corners = data.points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    records["normal"] = np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)
    records["corners"] = corners
    header = b"subdfit".ljust(80)
    return header + len(triangles).to_bytes(4, "little") + records.tobytes()

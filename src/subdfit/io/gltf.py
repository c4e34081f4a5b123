"""glTF: scenes read through trimesh; a tessellation written as one binary mesh.

Specification: Khronos glTF 2.0, https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html.
"""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np

from subdfit.errors import InputError
from subdfit.io.library import load
from subdfit.io.tessellation import triangles_of
from subdfit.mesh.data import MeshData

_MAGIC, _JSON, _BINARY = b"glTF", b"JSON", b"BIN\0"
_FLOAT, _UNSIGNED = 5126, 5125  # accessor component types, section 3.6.2.2
_VERTICES, _INDICES = 34962, 34963  # buffer view targets, section 3.6.2.1


def parse(content: bytes, path: Path) -> MeshData:
    """Read all meshes of a scene as one; raises InputError."""
    binary = content.startswith(_MAGIC)
    _check_claims(content, binary, path.name)
    return load(content, path, "glb" if binary else "gltf")


def _check_claims(content: bytes, binary: bool, name: str) -> None:
    """Refuse lengths and counts that the file cannot hold, before anything is allocated for them."""
    try:
        document = content
        if binary:
            version, total, size, kind = struct.unpack_from("<III4s", content, 4)
            if version != 2 or total != len(content) or kind != _JSON or 20 + size > len(content):
                raise ValueError(f"its header claims version {version} and {total} bytes, it has {len(content)}")
            document = content[20 : 20 + size]
        accessors = json.loads(document).get("accessors", [])
        if binary and any(not 0 <= accessor["count"] <= len(content) for accessor in accessors):
            raise ValueError("an accessor counts more than the file holds")
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, struct.error) as error:
        raise InputError(f"{name}: is no readable glTF 2 file ({error}); export it again") from None


def render(data: MeshData, path: Path) -> bytes:
    """Write a binary glTF with float32 positions (and normals); raises InputError unless all are triangles."""
    indices = triangles_of(data, path).astype("<u4").ravel()
    points = data.points.astype("<f4")
    blocks = [indices.tobytes(), points.tobytes()]
    accessors: list[dict[str, Any]] = [
        {"bufferView": 0, "componentType": _UNSIGNED, "count": len(indices), "type": "SCALAR"},
        {
            "bufferView": 1,
            "componentType": _FLOAT,
            "count": len(points),
            "type": "VEC3",
            "min": points.min(axis=0).tolist(),
            "max": points.max(axis=0).tolist(),
        },
    ]
    attributes = {"POSITION": 1}
    if data.normals is not None:
        blocks.append(data.normals.astype("<f4").tobytes())
        accessors.append({"bufferView": 2, "componentType": _FLOAT, "count": len(points), "type": "VEC3"})
        attributes["NORMAL"] = 2
    starts = np.cumsum([0, *map(len, blocks)]).tolist()
    document = {
        "asset": {"version": "2.0", "generator": "subdfit"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "indices": 0}]}],
        "accessors": accessors,
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(block), "target": _VERTICES if i else _INDICES}
            for i, (start, block) in enumerate(zip(starts, blocks, strict=False))
        ],
        "buffers": [{"byteLength": starts[-1]}],
    }
    return _container(json.dumps(document, separators=(",", ":")).encode(), b"".join(blocks))


def _container(document: bytes, binary: bytes) -> bytes:
    document += b" " * (-len(document) % 4)
    chunks = struct.pack("<I4s", len(document), _JSON) + document + struct.pack("<I4s", len(binary), _BINARY) + binary
    return _MAGIC + struct.pack("<II", 2, 12 + len(chunks)) + chunks

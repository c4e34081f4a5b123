"""What the formats for drawing share: triangles only, no creases."""

import logging
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.data import MeshData

logger = logging.getLogger(__name__)


def triangles_of(data: MeshData, path: Path) -> NDArray[np.int64]:
    """Return the faces as (m, 3); raises InputError for polygons or no face, warns of what the format drops."""
    if data.face_count == 0:
        raise InputError(f"{path.name}: {path.suffix} holds triangles and there are none; write points to .ply")
    if not data.triangles_only:
        raise InputError(f"{path.name}: {path.suffix} holds triangles only; cut the polygons, or write .obj or .ply")
    if data.scheme or len(data.crease_edges) or len(data.corner_vertices):
        logger.warning(
            "%s: %s cannot hold scheme, creases and corners; write .obj to keep them", path.name, path.suffix
        )
    return data.face_vertices.reshape(-1, 3)

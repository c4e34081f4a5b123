"""The formats for which a library does the reading; whatever goes wrong in it comes out as one line."""

import io
import logging
from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.mesh.data import MeshData


def load(content: bytes, path: Path, kind: str) -> MeshData:
    """Read with trimesh, which must neither merge nor drop anything; raises InputError for whatever fails in it.

    Scenes come out as one mesh, in the scene's frame; where there is no face, as their points.
    """
    try:
        import trimesh
    except ImportError:
        raise InputError(f"{path.name}: reading {path.suffix} needs trimesh; pip install trimesh") from None
    its_logger = logging.getLogger("trimesh")
    level = its_logger.level
    its_logger.setLevel(logging.CRITICAL)  # what it has to say, our error says in a line
    try:
        resolver = trimesh.resolvers.FilePathResolver(str(path))
        scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, resolver=resolver, process=False)
        parts = [part for part in scene.dump() if hasattr(part, "vertices")]
        meshes = [part for part in parts if hasattr(part, "faces") and len(part.faces)]
        sizes = [len(part.vertices) for part in meshes or parts]
        starts = np.cumsum([0, *sizes])[:-1]
        points = [np.asarray(part.vertices, np.float64) for part in meshes or parts]
        faces = [np.asarray(part.faces, np.int64) + start for part, start in zip(meshes, starts, strict=False)]
        corners = np.concatenate([np.empty(0, np.int64), *(rows.ravel() for rows in faces)])
        return MeshData(np.concatenate([np.empty((0, 3)), *points]), np.arange(0, len(corners) + 1, 3), corners)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0][:120]
        raise InputError(f"{path.name}: is no readable {kind.upper()} file ({reason}); export it again") from None
    finally:
        its_logger.setLevel(level)

"""XYZ point clouds: a line a point, ``x y z`` or ``x y z nx ny nz``; ``#`` starts a comment."""

from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.io.text import quote, table
from subdfit.mesh.data import MeshData


def parse(content: bytes, path: Path) -> MeshData:
    """Read points, and normals where each line has six numbers; raises InputError."""
    lines = ((n, line.partition(b"#")[0].split()) for n, line in enumerate(content.splitlines(), 1))
    rows = [(n, words) for n, words in lines if words]
    columns = len(rows[0][1]) if rows else 3
    if columns not in (3, 6):
        raise InputError(f"{path.name}: line {rows[0][0]} has {columns} numbers; a point has 3, or 6 with its normal")
    for n, words in rows:
        if len(words) != columns:
            shown = quote(b" ".join(words))
            raise InputError(f"{path.name}: line {n} '{shown}' has not {columns} numbers as the first; mend the line")
    values = table([words for _, words in rows], columns, path.name)
    points = np.ascontiguousarray(values[:, :3])
    normals = np.ascontiguousarray(values[:, 3:]) if columns == 6 else None
    return MeshData(points, np.zeros(1, np.int64), np.empty(0, np.int64), normals=normals)

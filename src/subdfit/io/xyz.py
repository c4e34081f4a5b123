"""XYZ point clouds: a line a point, ``x y z`` or ``x y z nx ny nz``; ``#`` starts a comment."""

import re
from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.io.text import Rows, quote, table
from subdfit.mesh.data import MeshData

_COMMENT = re.compile(rb"#[^\r\n]*")


def parse(content: bytes, path: Path) -> MeshData:
    """Read points, and normals where each line has six numbers; raises InputError."""
    lines = [line for line in _COMMENT.sub(b"", content).splitlines() if line.strip()]
    rows = Rows.of(lines)
    columns = int(rows.sizes[0]) if lines else 3
    if columns not in (3, 6):
        raise InputError(f"{path.name}: '{quote(lines[0])}' has {columns} numbers; a point has 3, or 6 with its normal")
    other = np.flatnonzero(rows.sizes != columns)
    if len(other):
        shown = quote(lines[other[0]])
        raise InputError(f"{path.name}: '{shown}' has not {columns} numbers as the first line; mend the line")
    values = table(rows, columns, path.name)
    points = np.ascontiguousarray(values[:, :3])
    normals = np.ascontiguousarray(values[:, 3:]) if columns == 6 else None
    return MeshData(points, np.zeros(1, np.int64), np.empty(0, np.int64), normals=normals)

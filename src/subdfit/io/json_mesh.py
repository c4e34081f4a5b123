"""Control meshes as JSON: one object that keeps everything `MeshData` holds.

``format`` is ``"subdfit mesh"`` and ``version`` 1; ``scheme`` is a name or null; ``interpolate_boundary`` is 0, 1, 2
or null. ``points`` is a list of ``[x, y, z]``; ``faces`` a list of lists of rows of `points`, counted from 0;
``creases`` a list of ``[row, row, sharpness]``; ``corners`` a list of ``[row, sharpness]``; ``normals`` a list of
``[x, y, z]``, one a point, or null. Sharpness 10 is sharp for ever.
"""

import json
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.io.tags import boundary_rule, finite_sharpness
from subdfit.mesh.data import MeshData

FORMAT, VERSION = "subdfit mesh", 1


def parse(content: bytes, path: Path) -> MeshData:
    """Read the object described above; raises InputError where it is none."""
    name = path.name
    try:
        document = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name}: is not JSON ({str(error).splitlines()[0]}); write it with subdfit convert") from None
    if not isinstance(document, dict) or document.get("format") != FORMAT or document.get("version") != VERSION:
        raise InputError(f'{name}: is not a mesh ("format": "{FORMAT}", "version": {VERSION}); convert from .obj')
    faces = _lists(document, "faces", None, name)
    creases = _lists(document, "creases", 3, name)
    corners = _lists(document, "corners", 2, name)
    scheme = document.get("scheme")
    if scheme is not None and not isinstance(scheme, str):
        raise InputError(f'{name}: "scheme" is not a name; give a string or null')
    return MeshData(
        points=_numbers(_lists(document, "points", 3, name), 3),
        face_offsets=np.concatenate(([0], np.cumsum([len(face) for face in faces], dtype=np.int64))),
        face_vertices=_rows(chain.from_iterable(faces), "faces", name),
        crease_edges=_rows(chain.from_iterable(row[:2] for row in creases), "creases", name).reshape(-1, 2),
        crease_sharpness=_numbers(creases, 3)[:, 2],
        corner_vertices=_rows((row[0] for row in corners), "corners", name),
        corner_sharpness=_numbers(corners, 2)[:, 1],
        normals=_numbers(_lists(document, "normals", 3, name), 3) if document.get("normals") else None,
        scheme=scheme,
        interpolate_boundary=boundary_rule(document.get("interpolate_boundary"), name),
    )


def render(data: MeshData, path: Path) -> bytes:
    """Write everything, a line a row, with digits that give the same float64 back."""
    corners, bounds = data.face_vertices.tolist(), data.face_offsets.tolist()
    creases = zip(data.crease_edges.tolist(), finite_sharpness(data.crease_sharpness).tolist(), strict=True)
    sharp_corners = zip(data.corner_vertices.tolist(), finite_sharpness(data.corner_sharpness).tolist(), strict=True)
    members = {
        "format": json.dumps(FORMAT),
        "version": str(VERSION),
        "scheme": json.dumps(data.scheme),
        "interpolate_boundary": json.dumps(data.interpolate_boundary),
        "points": _array(data.points.tolist()),
        "faces": _array([corners[start:end] for start, end in pairwise(bounds)]),
        "creases": _array([[*ends, sharpness] for ends, sharpness in creases]),
        "corners": _array([list(pair) for pair in sharp_corners]),
        "normals": "null" if data.normals is None else _array(data.normals.tolist()),
    }
    return ("{\n" + ",\n".join(f'"{key}": {text}' for key, text in members.items()) + "\n}\n").encode()


def _array(rows: list[Any]) -> str:
    return "[\n" + ",\n".join(map(json.dumps, rows)) + "\n]" if rows else "[]"


def _lists(document: dict[str, Any], key: str, columns: int | None, name: str) -> list[list[Any]]:
    """Return a member that is a list of lists of numbers, of equal length where `columns` says so."""
    rows = document.get(key, [])
    if not isinstance(rows, list):
        raise InputError(f'{name}: "{key}" is not a list; write the file again')
    for number, row in enumerate(rows):
        if not isinstance(row, list) or (columns is not None and len(row) != columns):
            raise InputError(f'{name}: row {number} of "{key}" has not {columns or "only"} numbers; mend it')
        if not all(type(value) is float or (type(value) is int and abs(value) < 2**63) for value in row):
            raise InputError(f'{name}: row {number} of "{key}" holds something that is no number; mend it')
    return rows


def _numbers(rows: list[list[Any]], columns: int) -> NDArray[np.float64]:
    return np.array(rows, np.float64).reshape(-1, columns)


def _rows(values: Any, key: str, name: str) -> NDArray[np.int64]:
    rows = list(values)
    if not all(type(value) is int for value in rows):
        raise InputError(f'{name}: "{key}" names a vertex by something that is no integer; mend it')
    return np.array(rows, np.int64)

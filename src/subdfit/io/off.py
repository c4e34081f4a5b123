"""OFF meshes, own reader: the libraries at hand turn polygons to triangles or refuse them.

Format as described at http://www.geomview.org/docs/html/OFF.html: text, a line a vertex and a line a face.
"""

import logging
import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.io.text import Rows, integers, quote, row_of, table
from subdfit.mesh.data import MeshData

logger = logging.getLogger(__name__)

_COMMENT = re.compile(rb"#[^\r\n]*")
_KEYWORD = re.compile(rb"(ST)?(C)?(N)?OFF")


def parse(content: bytes, path: Path) -> MeshData:
    """Read polygons, and normals of a NOFF file; colours and texture coordinates are skipped.

    Raises InputError where the counts and the lines disagree.
    """
    name = path.name
    plain = _COMMENT.sub(b"", content).splitlines()
    lines = [line for line in plain if line.strip()]
    first = lines[0].split() if lines else [b""]
    keyword = _KEYWORD.fullmatch(first[0])
    if keyword is None or first[1:2] == [b"BINARY"]:
        raise InputError(f"{name}: line 1 is not the keyword OFF of a text file; export it as ASCII OFF")
    head = first[1:] or (lines[1].split() if len(lines) > 1 else [])
    body = lines[1:] if first[1:] else lines[2:]
    counts = integers(head[:3], lambda _: f"{name}: counts").tolist()
    if len(counts) < 2 or min(counts) < 0:
        raise InputError(f"{name}: counts of vertices and faces are missing after OFF; export the file again")
    vertex_count, face_count = counts[:2]
    if len(body) != vertex_count + face_count:
        raise InputError(
            f"{name}: states {vertex_count} vertices and {face_count} faces but has {len(body)} lines of them; "
            "the file is cut or contradictory, export it again"
        )

    def place(row: int) -> str:
        """Where a row of the body stands."""
        numbers = [number for number, line in enumerate(plain, 1) if line.strip()]
        return f"{name}: line {numbers[len(lines) - len(body) + row]}"

    values = table(Rows.of(body[:vertex_count]), 6 if keyword[3] else 3, place)
    faces = Rows.of(body[vertex_count:])
    sizes = integers(faces.part(0, np.ones(face_count, np.int64)), lambda face: place(vertex_count + face))
    bad = np.flatnonzero((sizes < 0) | (sizes >= faces.sizes))
    if len(bad):
        shown = quote(faces.row(int(bad[0])))
        raise InputError(
            f"{place(vertex_count + int(bad[0]))}: face '{shown}' has not {sizes[bad[0]]} corners; mend the line"
        )
    return MeshData(
        points=np.ascontiguousarray(values[:, :3]),
        face_offsets=np.concatenate(([0], np.cumsum(sizes))),
        face_vertices=integers(faces.part(1, sizes), lambda word: place(vertex_count + row_of(word, sizes))),
        normals=np.ascontiguousarray(values[:, 3:]) if keyword[3] else None,
    )


def render(data: MeshData, path: Path) -> bytes:
    """Write positions and polygons; warns of each thing that OFF cannot hold."""
    lost = {
        "the subdivision scheme": data.scheme is not None,
        "the boundary rule": data.interpolate_boundary is not None,
        "creases": len(data.crease_edges) > 0,
        "corners": len(data.corner_vertices) > 0,
        "normals": data.normals is not None,
    }
    if any(lost.values()):
        what = ", ".join(thing for thing, there in lost.items() if there)
        logger.warning("%s: OFF cannot hold %s; write .obj, .ply or .json to keep all", path.name, what)
    lines = ["OFF", f"{len(data.points)} {data.face_count} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in data.points.tolist()]
    corners, bounds = data.face_vertices.tolist(), data.face_offsets.tolist()
    for start, end in pairwise(bounds):
        lines.append(f"{end - start} {' '.join(map(str, corners[start:end]))}")
    return ("\n".join(lines) + "\n").encode()

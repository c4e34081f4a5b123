"""OFF meshes, own reader: the libraries at hand turn polygons to triangles or refuse them.

Format as described at http://www.geomview.org/docs/html/OFF.html: text, a line a vertex and a line a face.
"""

import logging
import re
from itertools import chain, pairwise
from pathlib import Path

import numpy as np

from subdfit.errors import InputError
from subdfit.io.text import integers, quote, table
from subdfit.mesh.data import MeshData

logger = logging.getLogger(__name__)

_COMMENT = re.compile(rb"#[^\r\n]*")
_KEYWORD = re.compile(rb"(ST)?(C)?(N)?OFF")


def parse(content: bytes, path: Path) -> MeshData:
    """Read polygons, and normals of a NOFF file; colours and texture coordinates are skipped.

    Raises InputError where the counts and the lines disagree.
    """
    name = path.name
    rows = [words for line in _COMMENT.sub(b"", content).splitlines() if (words := line.split())]
    keyword = _KEYWORD.fullmatch(rows[0][0]) if rows else None
    if keyword is None or rows[0][1:2] == [b"BINARY"]:
        raise InputError(f"{name}: line 1 is not the keyword OFF of a text file; export it as ASCII OFF")
    head = rows[0][1:] or (rows[1] if len(rows) > 1 else [])
    body = rows[1:] if rows[0][1:] else rows[2:]
    counts = integers(head[:3], f"{name}: counts").tolist()
    if len(counts) < 2 or min(counts) < 0:
        raise InputError(f"{name}: counts of vertices and faces are missing after OFF; export the file again")
    vertex_count, face_count = counts[:2]
    if len(body) != vertex_count + face_count:
        raise InputError(
            f"{name}: states {vertex_count} vertices and {face_count} faces but has {len(body)} lines of them; "
            "the file is cut or contradictory, export it again"
        )
    values = table(body[:vertex_count], 6 if keyword[3] else 3, f"{name}: vertices")
    sizes = integers([words[0] for words in body[vertex_count:]], f"{name}: faces")
    for size, words in zip(sizes.tolist(), body[vertex_count:], strict=True):
        if not 0 <= size < len(words):
            raise InputError(f"{name}: face '{quote(b' '.join(words))}' has not {size} corners; mend the line")
    corners = chain.from_iterable(
        words[1 : size + 1] for size, words in zip(sizes.tolist(), body[vertex_count:], strict=True)
    )
    return MeshData(
        points=np.ascontiguousarray(values[:, :3]),
        face_offsets=np.concatenate(([0], np.cumsum(sizes))),
        face_vertices=integers(list(corners), f"{name}: faces"),
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

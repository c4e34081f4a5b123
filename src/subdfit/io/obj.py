"""Wavefront OBJ, with the scheme in a comment and OpenSubdiv's tags for creases, corners and the boundary rule.

Tags, as in the shapes of OpenSubdiv's regression tests: ``t NAME INTEGERS/FLOATS/STRINGS values...``; indices count `v`
lines from 0. ``t crease 2/1/0 i j S`` (more integers are a chain of edges), ``t corner 1/1/0 i S``,
``t interpolateboundary 1/0/0 N``; sharpness 10 is sharp for ever. Unknown statements and tags are skipped.
"""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.io.tags import boundary_rule, finite_sharpness
from subdfit.io.text import Place, Rows, floats, integers, quote, row_of, table
from subdfit.mesh.data import MeshData

_SCHEME = b"subdivision scheme:"
Words = list[bytes]


def parse(content: bytes, path: Path) -> MeshData:
    """Read polygons, or points where there is no face; raises InputError that quotes what it cannot read."""
    name = path.name
    lines, positions_before, normals_before, scheme = _statements(content)

    def place(keyword: bytes, row: int) -> str:
        """Where one of a keyword's statements stands."""
        return f"{name}: line {_line_number(content, keyword, row)}"

    points = table(Rows.of(lines[b"v"]), 3, lambda row: place(b"v", row), skip=1)
    normals = table(Rows.of(lines[b"vn"]), 3, lambda row: place(b"vn", row), skip=1)
    faces = Rows.of(lines[b"f"])
    sizes = faces.sizes - 1
    words = faces.part(1, sizes)
    normal_words = [b""] * len(words)
    if any(b"/" in word for word in words):
        parts = [word.split(b"/") for word in words]
        words = [part[0] for part in parts]
        normal_words = [part[2] if len(part) == 3 else b"" for part in parts]

    def corner_place(corner: int) -> str:
        return place(b"f", row_of(corner, sizes))

    corners = _from_zero(words, np.repeat(positions_before, sizes), len(points), corner_place)
    corner_normals = None
    if len(normals) and words and all(normal_words):
        corner_normals = _from_zero(normal_words, np.repeat(normals_before, sizes), len(normals), corner_place)
    return MeshData(
        points=points,
        face_offsets=np.concatenate(([0], np.cumsum(sizes))),
        face_vertices=corners,
        normals=_vertex_normals(normals, corners, corner_normals, len(points)),
        scheme=scheme,
        **_tags(lines[b"t"], name),
    )


def _statements(content: bytes) -> tuple[dict[bytes, list[bytes]], NDArray[np.int64], NDArray[np.int64], str | None]:
    """Sort the lines by statement; for each face, how many `v` and `vn` came before it; the scheme's name."""
    lines: dict[bytes, list[bytes]] = {b"v": [], b"vn": [], b"f": [], b"t": []}
    positions, normals = lines[b"v"], lines[b"vn"]
    positions_before, normals_before = list[int](), list[int]()
    scheme = None
    content = content.replace(b"\t", b" ").replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    for line in content.splitlines():
        keyword = line.partition(b" ")[0] or line.lstrip().partition(b" ")[0]
        if keyword in lines:
            lines[keyword].append(line)
            if keyword == b"f":
                positions_before.append(len(positions))
                normals_before.append(len(normals))
        elif keyword.startswith(b"#"):
            comment = line.strip(b"# ")
            if comment.startswith(_SCHEME):
                scheme = comment[len(_SCHEME) :].strip().decode("latin-1") or None
    return lines, np.array(positions_before, np.int64), np.array(normals_before, np.int64), scheme


def _line_number(content: bytes, keyword: bytes, row: int) -> int:
    """Number, from 1, of the line on which one of a keyword's statements begins."""
    lines = content.splitlines(keepends=True)
    goes_on = [False, *(line.endswith((b"\\\n", b"\\\r\n")) for line in lines)]
    words = [line.rstrip(b"\\\r\n").split(None, 1)[:1] for line in lines]
    return [number for number, word in enumerate(words, 1) if word == [keyword] and not goes_on[number - 1]][row]


def _from_zero(words: Words, before: NDArray[np.int64], count: int, where: Place) -> NDArray[np.int64]:
    """Row numbers, of so many, from OBJ indices, which count from 1, or back from the latest when negative."""
    indices = integers(words, where)
    rows = np.where(indices > 0, indices - 1, before + indices)
    bad = np.flatnonzero((indices == 0) | (rows < 0) | (rows >= count))
    if len(bad):
        index, place = indices[bad[0]], where(int(bad[0]))
        if index == 0:
            raise InputError(f"{place}: index 0 does not exist, OBJ counts from 1; export the file again")
        if index < 0:
            raise InputError(f"{place}: index {index} points before the first row; export the file again")
        raise InputError(f"{place}: names row {index}, there are {count}; export the file again")
    return rows


def _vertex_normals(
    normals: NDArray[np.float64],
    corners: NDArray[np.int64],
    corner_normals: NDArray[np.int64] | None,
    vertex_count: int,
) -> NDArray[np.float64] | None:
    """One normal a vertex, where the file gives just one to each; else None."""
    if not len(corners):
        return normals if vertex_count and len(normals) == vertex_count else None
    if corner_normals is None:
        return None
    rows = np.full(vertex_count, -1, np.int64)
    rows[corners] = corner_normals
    if rows.min() < 0 or not np.array_equal(normals[rows[corners]], normals[corner_normals]):
        return None
    return normals[rows]


def _tags(lines: list[bytes], name: str) -> dict[str, Any]:
    """Creases, corners and the boundary rule, as arguments of `MeshData`."""
    creases: list[tuple[int, int, float]] = []
    corners: list[tuple[int, float]] = []
    boundary = None
    for line in lines:
        words = line.split()[1:]
        if not words or words[0] not in (b"crease", b"corner", b"interpolateboundary"):
            continue
        rows_named, values = _tag_values(words, f"{name}: t {quote(b' '.join(words))}")
        if words[0] == b"interpolateboundary":
            boundary = boundary_rule(rows_named[0], name)
            continue
        if words[0] == b"corner":
            corners += zip(rows_named, _one_each(values, len(rows_named)), strict=True)
            continue
        sharpness = _one_each(values, len(rows_named) - 1)
        creases += zip(rows_named[:-1], rows_named[1:], sharpness, strict=True)
    creases = [crease for crease in creases if crease[2] != 0]
    corners = [corner for corner in corners if corner[1] != 0]
    return {
        "crease_edges": np.array([crease[:2] for crease in creases], np.int64).reshape(-1, 2),
        "crease_sharpness": np.array([crease[2] for crease in creases], np.float64),
        "corner_vertices": np.array([corner[0] for corner in corners], np.int64),
        "corner_sharpness": np.array([corner[1] for corner in corners], np.float64),
        "interpolate_boundary": boundary,
    }


def _tag_values(words: Words, where: str) -> tuple[list[int], list[float]]:
    """Integers and floats of a tag, whose numbers its third word announces."""
    counts = integers(words[1].split(b"/"), lambda _: where).tolist() if len(words) > 1 else []
    if len(counts) != 3 or min(counts) < 0 or sum(counts) != len(words) - 2:
        raise InputError(f"{where}: has not as many values as it announces; mend the tag")
    indices = integers(words[2 : 2 + counts[0]], lambda _: where).tolist()
    values = floats(words[2 + counts[0] : 2 + counts[0] + counts[1]], lambda _: where).tolist()
    needed = {b"crease": counts[0] - 1, b"corner": counts[0], b"interpolateboundary": 0}[words[0]]
    fewest = 2 if words[0] == b"crease" else 1
    if counts[0] < fewest or (needed and counts[1] not in (1, needed)):
        raise InputError(f"{where}: has not one sharpness for all or one for each; mend the tag")
    return indices, values


def _one_each(values: list[float], count: int) -> list[float]:
    return values if len(values) == count else values * count


def render(data: MeshData, path: Path) -> bytes:
    """Write positions with digits that give the same float64 back, polygons and tags."""
    lines = [f"# subdivision scheme: {data.scheme}"] if data.scheme is not None else []
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in data.points.tolist()]
    if data.normals is not None:
        lines += [f"vn {x!r} {y!r} {z!r}" for x, y, z in data.normals.tolist()]
    names = [str(row) for row in range(1, len(data.points) + 1)]
    if data.normals is not None:
        names = [f"{row}//{row}" for row in names]
    corners, bounds = [names[row] for row in data.face_vertices.tolist()], data.face_offsets.tolist()
    lines += [f"f {' '.join(corners[a:b])}" for a, b in pairwise(bounds)]
    if data.interpolate_boundary is not None:
        lines.append(f"t interpolateboundary 1/0/0 {data.interpolate_boundary}")
    creases = finite_sharpness(data.crease_sharpness).tolist()
    lines += [f"t crease 2/1/0 {i} {j} {s!r}" for (i, j), s in zip(data.crease_edges.tolist(), creases, strict=True)]
    sharp_corners = finite_sharpness(data.corner_sharpness).tolist()
    lines += [f"t corner 1/1/0 {i} {s!r}" for i, s in zip(data.corner_vertices.tolist(), sharp_corners, strict=True)]
    return ("\n".join(lines) + "\n").encode()

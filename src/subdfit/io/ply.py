"""PLY meshes and point clouds.

Beyond the usual elements `vertex` and `face`, an `edge` element with `vertex1 vertex2 sharpness` holds creases,
a vertex property `corner_sharpness` holds corners (0 is no corner), a face property `label` holds regions, and the
comments ``subdivision scheme: NAME`` and ``interpolate boundary: N`` hold the rest. Sharpness 10 is sharp for ever.
`tristrips` are read as triangles.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.io.ply_elements import Lists, Table, parse_header, parse_tables
from subdfit.io.tags import boundary_rule, finite_sharpness
from subdfit.mesh.data import MeshData

_LIST_NAMES = ("vertex_indices", "vertex_index")
_WANTED = {
    "vertex": {"x", "y", "z", "nx", "ny", "nz", "corner_sharpness"},
    "face": {*_LIST_NAMES, "label"},
    "tristrips": set(_LIST_NAMES),
    "edge": {"vertex1", "vertex2", "sharpness"},
}
_SCHEME, _BOUNDARY = "subdivision scheme:", "interpolate boundary:"


def parse(content: bytes, path: Path) -> MeshData:
    """Read text or binary PLY; raises InputError where header and body disagree."""
    name = path.name
    header = parse_header(content, name)
    tables = parse_tables(content, header, _WANTED, name)
    vertex = tables.get("vertex", {})
    points = _vectors(vertex, ("x", "y", "z"))
    if points is None:
        raise InputError(f"{name}: has no element 'vertex' with x, y and z; export it with positions")
    sizes, corners = _faces(tables, name)
    ends, sharpness = _creases(tables.get("edge", {}), name)
    corner_sharpness = _scalar(vertex, "corner_sharpness")
    sharp = np.empty(0, np.int64) if corner_sharpness is None else np.flatnonzero(corner_sharpness)
    return MeshData(
        points=points,
        face_offsets=np.concatenate(([0], np.cumsum(sizes))),
        face_vertices=corners,
        crease_edges=ends,
        crease_sharpness=sharpness,
        corner_vertices=sharp,
        corner_sharpness=np.empty(0) if corner_sharpness is None else corner_sharpness[sharp].astype(np.float64),
        normals=_vectors(vertex, ("nx", "ny", "nz")),
        scheme=_comment(header.comments, _SCHEME),
        interpolate_boundary=_boundary(header.comments, name),
        face_labels=_labels(tables, len(sizes), name),
    )


def _scalar(table: Table, column: str) -> NDArray[Any] | None:
    values = table.get(column)
    return None if isinstance(values, Lists) else values


def _vectors(table: Table, columns: tuple[str, ...]) -> NDArray[np.float64] | None:
    values = [_scalar(table, column) for column in columns]
    if any(column is None for column in values):
        return None
    return np.stack([np.asarray(column, np.float64) for column in values if column is not None], axis=1)


def _indices(values: NDArray[Any], name: str, element: str) -> NDArray[np.int64]:
    """Row numbers, which some exporters store as floats."""
    with np.errstate(invalid="ignore"):
        rows = values.astype(np.int64)
    if values.dtype.kind == "f" and not np.array_equal(rows, values):
        raise InputError(f"{name}: '{element}' names a vertex by a number that is no integer; export the file again")
    return rows


def _faces(tables: dict[str, Table], name: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Sizes and corners of all faces, those of triangle strips last."""
    sizes, corners = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for element in ("face", "tristrips"):
        if element not in tables:
            continue
        lists = next((rows for key in _LIST_NAMES if isinstance(rows := tables[element].get(key), Lists)), None)
        if lists is None:
            raise InputError(f"{name}: element '{element}' has no list vertex_indices; export the file again")
        rows = _indices(lists.values, name, element)
        if element == "tristrips":
            rows = _strip_triangles(lists.sizes, rows)
            sizes.append(np.full(len(rows) // 3, 3, np.int64))
        else:
            sizes.append(lists.sizes)
        corners.append(rows)
    return np.concatenate(sizes), np.concatenate(corners)


def _labels(tables: dict[str, Table], faces: int, name: str) -> NDArray[np.int64] | None:
    """Regions of the faces; triangle strips have none."""
    labels = _scalar(tables.get("face", {}), "label")
    return None if labels is None or len(labels) != faces else _indices(labels, name, "face")


def _strip_triangles(sizes: NDArray[np.int64], values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Corners of the triangles of strips, which -1 separates; every other triangle of a strip is turned round.

    Triangles that repeat a vertex only steer the strip and are left out.
    """
    strip = np.insert(values, np.cumsum(sizes), -1)
    place = np.arange(len(strip))
    begin = np.maximum.accumulate(np.where(strip < 0, place + 1, 0))
    a, b, c = strip[:-2], strip[1:-1], strip[2:]
    kept = (a >= 0) & (b >= 0) & (c >= 0) & (a != b) & (b != c) & (c != a)
    turned = ((place - begin)[:-2] & 1).astype(np.bool_)
    triangles = np.stack([np.where(turned, b, a), np.where(turned, a, b), c], axis=1)
    corners: NDArray[np.int64] = triangles[kept].ravel()
    return corners


def _creases(edge: Table, name: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Edges with a sharpness; an edge element without one is a drawing's wires."""
    first, second, sharpness = (_scalar(edge, column) for column in ("vertex1", "vertex2", "sharpness"))
    if first is None or second is None or sharpness is None:
        return np.empty((0, 2), np.int64), np.empty(0)
    sharp = sharpness != 0
    ends = np.stack([_indices(first, name, "edge"), _indices(second, name, "edge")], axis=1)
    return ends[sharp], sharpness[sharp].astype(np.float64)


def _comment(comments: list[str], key: str) -> str | None:
    found = [text[len(key) :].strip() for text in comments if text.startswith(key)]
    return found[-1] or None if found else None


def _boundary(comments: list[str], name: str) -> int | None:
    text = _comment(comments, _BOUNDARY)
    return boundary_rule(int(text) if text is not None and text.isascii() and text.isdigit() else text, name)


def render(data: MeshData, path: Path) -> bytes:
    """Write binary little-endian PLY with double positions."""
    lines = ["ply", "format binary_little_endian 1.0"]
    if data.scheme is not None:
        lines.append(f"comment {_SCHEME} {data.scheme}")
    if data.interpolate_boundary is not None:
        lines.append(f"comment {_BOUNDARY} {data.interpolate_boundary}")
    columns = {axis: data.points[:, i] for i, axis in enumerate("xyz")}
    if data.normals is not None:
        columns |= {f"n{axis}": data.normals[:, i] for i, axis in enumerate("xyz")}
    if len(data.corner_vertices):
        columns["corner_sharpness"] = np.zeros(len(data.points))
        columns["corner_sharpness"][data.corner_vertices] = finite_sharpness(data.corner_sharpness)
    lines += [f"element vertex {len(data.points)}", *(f"property double {key}" for key in columns)]
    blocks = [np.stack(list(columns.values()), axis=1).astype("<f8").tobytes()]
    if data.face_count:
        count_type = "uchar" if np.diff(data.face_offsets).max() < 256 else "int"
        lines += [f"element face {data.face_count}", f"property list {count_type} int vertex_indices"]
        lines += ["property int label"] * (data.face_labels is not None)
        blocks.append(_face_rows(data, "u1" if count_type == "uchar" else "<i4"))
    if len(data.crease_edges):
        lines += [f"element edge {len(data.crease_edges)}", "property int vertex1", "property int vertex2"]
        lines.append("property double sharpness")
        edges = np.empty(len(data.crease_edges), [("ends", "<i4", 2), ("sharpness", "<f8")])
        edges["ends"], edges["sharpness"] = data.crease_edges, finite_sharpness(data.crease_sharpness)
        blocks.append(edges.tobytes())
    return "\n".join([*lines, "end_header\n"]).encode() + b"".join(blocks)


def _face_rows(data: MeshData, count_kind: str) -> bytes:
    """Rows of count, corners and label if there are any, one size of face at a time."""
    sizes = np.diff(data.face_offsets)
    labels = np.empty((len(sizes), 0), "<i4") if data.face_labels is None else data.face_labels[:, None].astype("<i4")
    head, tail = np.dtype(count_kind).itemsize, labels.shape[1]
    row_bytes = head + 4 * (sizes + tail)
    starts = np.cumsum(row_bytes) - row_bytes
    buffer = np.empty(int(row_bytes.sum()), np.uint8)
    for size in np.unique(sizes):
        faces = np.flatnonzero(sizes == size)
        rows = np.empty(
            len(faces), [("count", count_kind), ("corners", "<i4", (int(size),)), ("label", "<i4", (tail,))]
        )
        rows["count"] = size
        rows["corners"] = data.face_vertices[data.face_offsets[faces, None] + np.arange(size)]
        rows["label"] = labels[faces]
        width = np.arange(head + 4 * (size + tail))
        buffer[starts[faces, None] + width] = rows.view(np.uint8).reshape(len(faces), -1)
    return buffer.tobytes()

"""What is given to the editor, checked; every fault raises InputError."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh.data import SHARP_FOR_EVER


def checked_triangles(points: NDArray[np.float64], triangles: NDArray[Any]) -> NDArray[np.int64]:
    """Triangles, (m, 3), whose vertices exist and differ."""
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InputError(f"the points are {points.shape} or not all finite: give (n, 3) finite numbers")
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not np.issubdtype(triangles.dtype, np.integer):
        raise InputError(f"the triangles have shape {triangles.shape}: give (m, 3) integers")
    if len(triangles) == 0:
        raise InputError("the mesh has no triangles: give one at least")
    rows = checked_rows(triangles.astype(np.int64), len(points), "a triangle names vertex")
    repeated = (rows == np.roll(rows, -1, axis=1)).any(axis=1)
    if repeated.any():
        raise InputError(f"triangle {repeated.argmax()} repeats a vertex: remove it")
    return rows


def paired_half_edges(triangles: NDArray[np.int64], vertices: int) -> NDArray[np.int32]:
    """Opposite half-edge of each, -1 on the boundary."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    keys = a * vertices + b
    again = first_rows(keys, keys) != np.arange(len(keys))
    if again.any():
        h = again.argmax()
        raise InputError(f"edge ({a[h]}, {b[h]}) runs the same way in two triangles: orient them alike")
    twin = first_rows(keys, b * vertices + a)
    apex = np.roll(triangles, 1, axis=1).ravel()
    same = (twin >= 0) & (apex == apex[twin])
    if same.any():
        h = int(same.argmax())
        raise InputError(f"triangles {h // 3} and {twin[h] // 3} have the same corners: remove one")
    return twin.astype(np.int32)


def first_rows(keys: NDArray[np.int64], wanted: NDArray[np.int64]) -> NDArray[np.int64]:
    """First row of `keys` that holds each wanted key, -1 where none does."""
    order = np.argsort(keys, kind="stable")
    at = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
    return np.where(keys[at] == wanted, at, -1)


def checked_rows(rows: NDArray[Any], count: int, what: str) -> NDArray[Any]:
    """The rows, checked to lie in ``range(count)``."""
    outside = rows[(rows < 0) | (rows >= count)]
    if len(outside):
        raise InputError(f"{what} {outside[0]}, of {count}: give rows from 0 to {count - 1}")
    return rows


def checked_mask(mask: ArrayLike, shape: tuple[int, ...], what: str) -> NDArray[np.bool_]:
    """The mask, contiguous, of the shape asked."""
    chosen = np.ascontiguousarray(mask)
    if chosen.dtype != np.bool_ or chosen.shape != shape:
        raise InputError(f"the mask of {what} is {chosen.dtype} {chosen.shape}: give bool {shape}")
    return chosen


def checked_edges(edges: ArrayLike | None) -> NDArray[np.int64]:
    """Ends of edges, (k, 2)."""
    pairs = np.empty((0, 2), np.int64) if edges is None else np.asarray(edges)
    if len(pairs) == 0:
        return np.empty((0, 2), np.int64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not np.issubdtype(pairs.dtype, np.integer):
        raise InputError(f"the edges have shape {pairs.shape}: give (k, 2) integers, rows of points")
    return np.ascontiguousarray(pairs, np.int64)


def checked_sharpness(sharpness: ArrayLike | None, count: int, what: str) -> NDArray[np.float64]:
    """One sharpness above 0 for each; sharp for ever where none is given."""
    if sharpness is None:
        return np.full(count, SHARP_FOR_EVER)
    values = np.asarray(sharpness, np.float64)
    if values.shape != (count,) or not (values > 0).all():
        raise InputError(f"{what} sharpness has shape {values.shape}: give {count} numbers above 0")
    return values

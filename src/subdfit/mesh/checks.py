"""What callers give, as arrays that loops may trust; every fault raises InputError."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh.data import positions

Floats = NDArray[np.float64]
Whole = NDArray[Any]


def numbers(given: ArrayLike, what: str) -> Floats:
    """An array of numbers, (...) float64."""
    try:
        return np.asarray(given, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what} are no array of numbers; give one") from None


def positive_length(given: float, what: str) -> float:
    """A length above 0."""
    try:
        length = float(given)
    except (TypeError, ValueError):
        length = np.nan
    if not length > 0:
        raise InputError(f"{what} is {given}; give a positive length in the unit of the points")
    return length


def finite_points(given: ArrayLike, of: str) -> Floats:
    """Points (n, 3) float64, n >= 1, all finite; `of` says what they are points of."""
    points = positions(given)
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InputError(f"the {of} needs points with three coordinates; got an array of shape {points.shape}")
    if not np.isfinite(points).all():
        row = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise InputError(f"point {row} of the {of} is not finite; remove or correct it")
    return points


def whole_numbers(given: ArrayLike, what: str) -> Whole:
    """An array of whole numbers, of whatever type it has."""
    try:
        array = np.asarray(given)
    except ValueError as error:
        raise InputError(f"{what} come in rows of unlike length; give an array") from error
    if array.dtype.kind not in "iuf" or (array.dtype.kind == "f" and not np.array_equal(array, np.floor(array))):
        raise InputError(f"{what} are not whole numbers; give integers")
    return array


def whole_rows(given: ArrayLike, columns: int, what: str) -> Whole:
    """Rows (m, columns) of whole numbers, of whatever type they have."""
    rows = whole_numbers(given, what)
    if rows.size and (rows.ndim != 2 or rows.shape[1] != columns):
        raise InputError(f"{what} come in shape {rows.shape}; give {columns} vertices a row")
    return rows.reshape(-1, columns)


def _below(given: Whole, count: int, what: str) -> NDArray[np.int64]:
    """Whole numbers, of any shape, from 0 to less than `count`."""
    outside = (given < 0) | (given >= count)
    if outside.any():
        row = int(np.argmax(outside.reshape(len(given), -1).any(axis=1)))
        raise InputError(f"{what} name {given[outside][0]} in row {row}, outside 0..{count - 1}; count from 0")
    return given.astype(np.int64, copy=False)


def row_numbers(given: ArrayLike, count: int, what: str) -> NDArray[np.int64]:
    """Row numbers (k,) from 0 to less than `count`."""
    rows = whole_numbers(given, what)
    if rows.ndim != 1:
        raise InputError(f"{what} come in shape {rows.shape}; give a list of numbers")
    return _below(rows, count, what)


def row_pairs(given: ArrayLike, count: int, what: str) -> NDArray[np.int64]:
    """Pairs (k, 2) of row numbers from 0 to less than `count`."""
    return _below(whole_rows(given, 2, what), count, what)


def triangle_rows(given: ArrayLike, count: int) -> NDArray[np.int64]:
    """Triangles (m, 3), m >= 1, among `count` points."""
    rows = _below(whole_rows(given, 3, "triangles"), count, "triangles")
    if len(rows) == 0:
        raise InputError("the mesh has no triangles; give one or more")
    return rows

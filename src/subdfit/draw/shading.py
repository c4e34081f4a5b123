"""Light: which way faces look, smooth normals, soft shadows and three lamps; plain numpy, no graphics card."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

KEY = np.array([-0.46, 0.62, 0.64], np.float32)
FILL = np.array([0.80, 0.05, 0.60], np.float32)
RIM = np.array([0.35, 0.75, -0.56], np.float32)
"""Directions towards the lamps in the camera's frame: right, up, to the viewer."""

_SHARP = np.cos(np.radians(35.0))
"""Edges across which the surface turns further than this are sharp."""
_BENT = np.cos(np.radians(17.5))
"""At a vertex of a sharp edge some face is turned further than this from the mean of all."""

_REACH = (0.010, 0.045)
"""Widths of the soft shadows, as shares of the picture's larger side."""
_STRENGTH = (0.30, 0.28)
"""How much light the deepest hollow loses, for each reach."""


def is_closed(triangles: NDArray[np.integer]) -> bool:
    """Return whether each directed edge of an oriented mesh meets its opposite exactly once."""
    tail = triangles.astype(np.int64).ravel()
    head = np.roll(triangles, -1, axis=1).astype(np.int64).ravel()
    count = int(tail.max(initial=0)) + 1
    forward, backward = np.sort(tail * count + head), np.sort(head * count + tail)
    return bool(np.array_equal(forward, backward) and np.all(np.diff(forward) > 0))


def signed_volume(vertices: NDArray[np.floating], triangles: NDArray[np.integer]) -> float:
    """Return the volume enclosed by a closed mesh; negative when its faces look inwards."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def smooth_normals(vertices: NDArray[np.floating], triangles: NDArray[np.integer]) -> NDArray[np.float32]:
    """Return (m, 3) unit normals, one a face: the mean over its corners of the normal of the surface there.

    At a vertex on a sharp edge each side of the edge has a normal of its own.
    """
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a).astype(np.float32)
    own = unit(areas)
    at_corners = _summed(areas, triangles, len(vertices))
    bent = np.zeros(len(vertices), np.bool_)
    bent[triangles[np.einsum("fci,fi->fc", at_corners, own) < _BENT]] = True
    near = np.flatnonzero(bent[triangles].any(axis=1))
    if len(near):
        fans = _fans(triangles[near], own[near])
        split = _summed(areas[near], fans, int(fans.max()) + 1)
        at_corners[near] = np.where(bent[triangles[near]][:, :, None], split, at_corners[near])
    return unit(np.asarray(at_corners.sum(axis=1), np.float32))


def _summed(areas: NDArray[np.float32], places: NDArray[np.integer], count: int) -> NDArray[np.float32]:
    """Return (m, 3, 3) unit normals at corners: of the sum of the areas of all triangles with a corner in its place."""
    sums = np.empty((count, 3), np.float32)
    for axis in range(3):
        sums[:, axis] = np.bincount(places.ravel(), np.repeat(areas[:, axis], 3), minlength=count)
    return np.asarray(unit(sums)[places])


def _fans(triangles: NDArray[np.integer], normals: NDArray[np.float32]) -> NDArray[np.int64]:
    """Number (m, 3) the fans of corners that meet at a vertex and are joined across edges that are not sharp."""
    tail, head = triangles.ravel().astype(np.int64), np.roll(triangles, -1, axis=1).ravel().astype(np.int64)
    count = int(tail.max()) + 1
    key, opposite = tail * count + head, head * count + tail
    order = np.argsort(key, kind="stable")
    twin = order[np.minimum(np.searchsorted(key[order], opposite), len(order) - 1)]
    flat = np.einsum("ij,ij->i", normals[np.arange(len(key)) // 3], normals[twin // 3]) > _SHARP
    side = np.flatnonzero((key[twin] == opposite) & flat)
    # The corner at an edge's tail is beside the corner at its twin's head.
    beside = 3 * (twin[side] // 3) + (twin[side] + 1) % 3
    links = coo_array((np.ones(len(side), np.int8), (side, beside)), shape=(len(key),) * 2)
    return np.asarray(connected_components(links, directed=False)[1].reshape(-1, 3), np.int64)


def unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the vectors at length one; those of no length stay zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, np.float32(1.0))[:, None], np.float32)


def openness(seen: NDArray[np.float32], window: tuple[float, float, float, float], cells: int) -> NDArray[np.float32]:
    """Return (n,) how freely points see the sky, from their depth alone; 1 is free.

    The depth is compared with its own blurred copy: what lies below its surroundings darkens (Luft, Colditz
    and Deussen 2006, "Image enhancement by unsharp masking the depth buffer").

    Parameters
    ----------
    seen : (n, 3), from `Camera.project`: right, up, and the height towards the viewer.
    window : left, right, bottom and top of the picture.
    cells : number of cells along its larger side, in which the highest point counts.
    """
    left, right, bottom, top = window
    side = max(right - left, top - bottom)
    shape = np.array([right - left, top - bottom]) / side * cells
    column, row = np.clip((seen[:, :2] - (left, bottom)) / side * cells, 0, shape).astype(np.int64).T
    highest = np.full(shape.astype(np.int64) + 1, -np.inf, np.float32)
    np.maximum.at(highest, (column, row), seen[:, 2])
    known = np.isfinite(highest)
    weight, height = known.astype(np.float32), np.where(known, highest, np.float32(0.0))
    free = np.ones(len(seen), np.float32)
    for reach, strength in zip(_REACH, _STRENGTH, strict=True):
        near = ndimage.gaussian_filter(weight, reach * cells)
        around = ndimage.gaussian_filter(height, reach * cells) / np.maximum(near, 1e-6)
        below = np.clip((around[column, row] - seen[:, 2]) / (reach * side), 0.0, 1.0)
        free *= 1.0 - strength * below
    return free


def lit(
    normals: NDArray[np.float32], albedo: NDArray[np.float32], open_sky: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Return (m, 3) colours of faces under key, fill and rim light.

    Parameters
    ----------
    normals : (m, 3) unit normals in the camera's frame, turned to the viewer.
    albedo : (m, 3) colours of the material, 0 to 1.
    open_sky : (m,) from 0 (deep in a hollow) to 1 (free).
    """
    key = np.clip(0.8 * (normals @ KEY) + 0.2, 0.0, None)
    fill = np.clip(0.7 * (normals @ FILL) + 0.3, 0.0, None)
    sky = 0.5 + 0.5 * normals[:, 1]
    diffuse = open_sky * (0.26 + 0.60 * key + 0.24 * fill + 0.14 * sky)
    half = unit((KEY + np.array([0.0, 0.0, 1.0], np.float32))[None, :])[0]
    shine = 0.16 * open_sky * np.clip(normals @ half, 0.0, None) ** 40
    edge = 0.35 * np.clip(normals @ RIM, 0.0, None) * (1.0 - np.clip(normals[:, 2], 0.0, 1.0)) ** 2
    glow = (shine + edge)[:, None]
    return np.asarray(np.clip(albedo * diffuse[:, None] * (1.0 - glow) + glow, 0.0, 1.0), np.float32)

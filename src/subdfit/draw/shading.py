"""Light: smooth normals, three lamps and the soft shadow in hollows; plain numpy, no graphics card."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

KEY = np.array([-0.46, 0.62, 0.64], np.float32)
FILL = np.array([0.80, 0.05, 0.60], np.float32)
RIM = np.array([0.35, 0.75, -0.56], np.float32)
"""Directions towards the lamps in the camera's frame: right, up, to the viewer."""

_SHARP = np.cos(np.radians(35.0))
"""A face that turns away further than this from the average around it is seen as the side of a sharp edge."""

_HOLLOW_REACH = (0.012, 0.05)
"""Widths of the soft shadows, as shares of the picture's larger side."""

_HOLLOW_DEPTH = 0.9
"""How strongly a hollow darkens."""


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
    """Return (m, 3) unit normals a face: the mean of its corners' normals, or its own where it borders a sharp edge."""
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    at_vertices = np.empty((len(vertices), 3), np.float32)
    for axis in range(3):
        weights = np.repeat(areas[:, axis], 3)
        at_vertices[:, axis] = np.bincount(triangles.ravel(), weights, minlength=len(vertices))
    smooth = unit(unit(at_vertices)[triangles].sum(axis=1))
    own = unit(areas.astype(np.float32))
    sharp = np.einsum("ij,ij->i", smooth, own) < _SHARP
    smooth[sharp] = own[sharp]
    return smooth


def unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the vectors at length one; those of no length stay zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.where(lengths > 0.0, lengths, np.float32(1.0))[:, None]


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
    key = np.clip(0.85 * (normals @ KEY) + 0.15, 0.0, None)
    fill = np.clip(0.7 * (normals @ FILL) + 0.3, 0.0, None)
    sky = 0.5 + 0.5 * normals[:, 1]
    diffuse = open_sky * (0.24 + 0.66 * key + 0.13 * fill + 0.12 * sky)
    half = unit((KEY + np.array([0.0, 0.0, 1.0], np.float32))[None, :])[0]
    shine = 0.16 * open_sky * np.clip(normals @ half, 0.0, None) ** 40
    edge = 0.35 * np.clip(normals @ RIM, 0.0, None) * (1.0 - np.clip(normals[:, 2], 0.0, 1.0)) ** 2
    glow = (shine + edge)[:, None]
    return np.clip(albedo * diffuse[:, None] * (1.0 - glow) + glow, 0.0, 1.0).astype(np.float32)


def openness(
    seen: NDArray[np.float32], window: tuple[float, float, float, float], pixels: int
) -> NDArray[np.float32]:
    """Return (m,) how freely each point sees the sky, judged from the picture's depth alone.

    The depth of the nearest points is compared with its own blurred copy: what lies below its surroundings darkens
    (Luft, Colditz and Deussen 2006, "Image enhancement by unsharp masking the depth buffer", equation 1).

    Parameters
    ----------
    seen : (m, 3) float32, from `Camera.project`.
    window : that of the camera.
    pixels : number of cells along the larger side of the depth picture.
    """
    left, right, bottom, top = window
    side = max(right - left, top - bottom)
    cell = side / pixels
    shape = (int((top - bottom) / cell) + 1, int((right - left) / cell) + 1)
    row = np.clip(((seen[:, 1] - bottom) / cell).astype(np.int64), 0, shape[0] - 1)
    column = np.clip(((seen[:, 0] - left) / cell).astype(np.int64), 0, shape[1] - 1)
    depth = np.full(shape, -np.inf, np.float32)
    np.maximum.at(depth, (row, column), seen[:, 2])
    known = np.isfinite(depth).astype(np.float32)
    depth[known == 0.0] = 0.0
    free = np.ones(len(seen), np.float32)
    for reach in _HOLLOW_REACH:
        weight = ndimage.gaussian_filter(known, reach * pixels)
        around = ndimage.gaussian_filter(depth, reach * pixels) / np.maximum(weight, 1e-6)
        below = np.clip(around[row, column] - seen[:, 2], 0.0, None) / (reach * side)
        free *= 1.0 / (1.0 + _HOLLOW_DEPTH * below)
    return free

"""Light: which way faces look, smooth normals and three lamps; plain numpy, no graphics card."""

import numpy as np
from numpy.typing import NDArray

KEY = np.array([-0.46, 0.62, 0.64], np.float32)
FILL = np.array([0.80, 0.05, 0.60], np.float32)
RIM = np.array([0.35, 0.75, -0.56], np.float32)
"""Directions towards the lamps in the camera's frame: right, up, to the viewer."""

_SHARP = np.cos(np.radians(35.0))
"""A face turned further than this from a vertex normal has a sharp edge there."""


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
    """Return (m, 3) unit normals, one a face: the mean over its corners of the vertex normal.

    A corner on a sharp edge, where the vertex normal belongs to neither side, counts with the face's own normal.
    """
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    at_vertices = np.empty((len(vertices), 3), np.float32)
    for axis in range(3):
        weights = np.repeat(areas[:, axis], 3)
        at_vertices[:, axis] = np.bincount(triangles.ravel(), weights, minlength=len(vertices))
    vertex_normals = unit(at_vertices)
    own = unit(areas.astype(np.float32))
    total = np.zeros_like(own)
    for corner in range(3):
        normal = vertex_normals[triangles[:, corner]]
        sharp = np.einsum("ij,ij->i", normal, own) < _SHARP
        total += np.where(sharp[:, None], own, normal)
    return unit(total)


def unit(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the vectors at length one; those of no length stay zero."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return np.asarray(vectors / np.where(lengths > 0.0, lengths, np.float32(1.0))[:, None], np.float32)


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

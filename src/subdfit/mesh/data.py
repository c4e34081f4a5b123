"""What a file says of a mesh, before anyone has judged it: plain arrays, no connectivity."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError

SHARP_FOR_EVER = 10.0
"""Sharpness from which a crease or corner never smooths (OpenSubdiv's convention)."""


def _no_edges() -> NDArray[np.int64]:
    return np.empty((0, 2), np.int64)


def _no_numbers() -> NDArray[np.float64]:
    return np.empty(0)


def _no_indices() -> NDArray[np.int64]:
    return np.empty(0, np.int64)


def positions(given: ArrayLike) -> NDArray[np.float64]:
    """Positions as float64; raises InputError for what are no real numbers."""
    try:
        values = np.asarray(given)
        if np.iscomplexobj(values):
            raise TypeError("they are complex")
        return np.ascontiguousarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"the vertices are no array of numbers ({error}); give one row of three real ones each"
        ) from None


@dataclass(frozen=True)
class MeshData:
    """Polygons (or bare points) as read from a file.

    Attributes
    ----------
    points : (n, 3) float64, in the file's unit.
    face_offsets : (m + 1,) int64; face ``f`` has the corners ``face_vertices[face_offsets[f]:face_offsets[f + 1]]``.
    face_vertices : int64, rows of `points`.
    crease_edges : (e, 2) int64, rows of `points`; `crease_sharpness` (e,) float64.
    corner_vertices : (c,) int64; `corner_sharpness` (c,) float64.
    normals : (n, 3) float64 or None.
    scheme : name of the subdivision scheme the file states, or None.
    face_labels : (m,) int64, the region to which each face belongs, or None; PLY files alone keep them.
    interpolate_boundary : 2 boundary edges are sharp, 1 and boundary corners with one face too, 0 none; None unsaid.
    """

    points: NDArray[np.float64]
    face_offsets: NDArray[np.int64]
    face_vertices: NDArray[np.int64]
    crease_edges: NDArray[np.int64] = field(default_factory=_no_edges)
    crease_sharpness: NDArray[np.float64] = field(default_factory=_no_numbers)
    corner_vertices: NDArray[np.int64] = field(default_factory=_no_indices)
    corner_sharpness: NDArray[np.float64] = field(default_factory=_no_numbers)
    normals: NDArray[np.float64] | None = None
    scheme: str | None = None
    interpolate_boundary: int | None = None
    face_labels: NDArray[np.int64] | None = None

    @property
    def face_count(self) -> int:
        """Number of polygons; 0 for a point cloud."""
        return len(self.face_offsets) - 1

    @property
    def triangles_only(self) -> bool:
        """Whether every face has three corners."""
        return bool(np.all(np.diff(self.face_offsets) == 3))

"""The eye: where a picture looks from, and how points reach the paper."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError

_VIEWS = ((32.0, 20.0), (-32.0, 20.0), (62.0, 20.0), (32.0, 55.0))
"""Azimuth and elevation in degrees, the preferred view first; the last one is for flat, lying models."""

_ENOUGH = 0.7
"""A view is good enough when it shows this share of the area that the best of the views shows."""

_UP = {"y": np.eye(3), "z": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])}
"""Rows: the model's right, up and front, for models that stand along y or along z."""


@dataclass(frozen=True)
class Camera:
    """A mild perspective view of a model.

    Attributes
    ----------
    rotation : (3, 3) float64; rows point right, up and to the viewer.
    centre : (3,) float64, the point looked at, in the model's unit.
    distance : distance from the eye to `centre`, in the model's unit.
    window : (left, right, bottom, top) of the picture in the plane through `centre`.
    """

    rotation: NDArray[np.float64]
    centre: NDArray[np.float64]
    distance: float
    window: tuple[float, float, float, float]

    def project(self, points: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return (n, 3): right and up on the picture, and the height over the picture plane (larger is nearer)."""
        seen = (np.asarray(points, np.float64) - self.centre) @ self.rotation.T
        seen[:, :2] *= self.nearness(seen[:, 2])[:, None]
        return seen.astype(np.float32)

    def nearness(self, height: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the scale at which heights are seen, 1 in the plane through `centre`; linear on pictures of planes."""
        return self.distance / np.maximum(self.distance - np.asarray(height, np.float64), 0.1 * self.distance)

    def height(self, nearness: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the heights that are seen at a scale."""
        return self.distance - self.distance / np.asarray(nearness, np.float64)

    @property
    def aspect(self) -> float:
        """Width of the window over its height."""
        left, right, bottom, top = self.window
        return (right - left) / (top - bottom)


def camera_for(
    vertices: ArrayLike,
    triangles: ArrayLike,
    *,
    azimuth: float | None = None,
    elevation: float | None = None,
    up: str = "y",
    margin: float = 0.03,
) -> Camera:
    """Return a camera that frames a mesh tightly, from a three-quarter view unless told otherwise.

    Parameters
    ----------
    vertices : (n, 3) array; vertices that no triangle uses do not count.
    triangles : (m, 3) array of rows of `vertices`.
    azimuth, elevation
        Degrees to the right of the model's front (+z when `up` is y, -y when it is z), and above its horizon.
        ``None`` takes the first usual view that shows enough of the model's area.
    up
        The axis along which the model stands: ``"y"`` (most scans) or ``"z"`` (most CAD).
    margin
        Free border as a share of the picture's larger side.

    Raises
    ------
    InputError
        When the mesh has no triangle, or `up` is not an axis known.
    """
    if up not in _UP:
        raise InputError(f"up axis {up!r} is not known: use 'y' or 'z'")
    faces = np.asarray(triangles, np.int64)
    if len(faces) == 0:
        raise InputError("a mesh without triangles cannot be drawn: give at least one triangle")
    points = np.asarray(vertices, np.float64)
    views = [(a if azimuth is None else azimuth, e if elevation is None else elevation) for a, e in _VIEWS]
    rotation = _first_telling(points, faces, [_view(*view, up) for view in views])
    points = points[np.unique(faces)]
    low, high = points.min(axis=0), points.max(axis=0)
    centre = 0.5 * (low + high)
    distance = 3.0 * max(float(np.linalg.norm(high - low)), 1e-30)
    camera = Camera(rotation, centre, distance, (-1.0, 1.0, -1.0, 1.0))
    seen = camera.project(points)[:, :2].astype(np.float64)
    (left, bottom), (right, top) = seen.min(axis=0).tolist(), seen.max(axis=0).tolist()
    border = max(margin * max(right - left, top - bottom), 1e-6 * distance)
    return Camera(rotation, centre, distance, (left - border, right + border, bottom - border, top + border))


def _view(azimuth: float, elevation: float, up: str) -> NDArray[np.float64]:
    a, e = np.radians([azimuth, elevation])
    right = [np.cos(a), 0.0, -np.sin(a)]
    above = [-np.sin(e) * np.sin(a), np.cos(e), -np.sin(e) * np.cos(a)]
    viewer = [np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)]
    rotation: NDArray[np.float64] = np.array([right, above, viewer]) @ _UP[up]
    return rotation


def _first_telling(
    points: NDArray[np.float64], faces: NDArray[np.int64], rotations: list[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Return the first of the rotations that shows enough of the area that the best of them shows."""
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    areas = np.cross(b - a, c - a)
    shown = np.array([np.abs(areas @ rotation[2]).sum() for rotation in rotations])
    return rotations[int(np.argmax(shown >= _ENOUGH * shown.max()))]

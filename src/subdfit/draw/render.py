"""Shaded triangles on a matplotlib axes: painted from far to near, without a display or a graphics card."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Colormap, Normalize, to_rgb
from numpy.typing import ArrayLike, NDArray

from subdfit.draw.camera import Camera
from subdfit.draw.depth import DepthPicture
from subdfit.draw.shading import is_closed, lit, signed_volume, smooth_normals
from subdfit.errors import InputError

PLASTER = (0.89, 0.875, 0.85)
"""Colour of a surface for which none is given."""

_INSIDE = np.array([0.62, 0.68, 0.78], np.float32)
"""Tint of the inner side of an open surface."""

_MANY = 200_000
"""From this many triangles on, hidden ones are left out and those smaller than a pixel are merged."""


_SEAM = 0.3
"""Width in points of the outline, of its own colour, that closes the seam between neighbouring triangles."""


@dataclass(frozen=True)
class _Sheet:
    """Triangles on paper: corners (m, 3, 2), height of the centres (m,), colours (m, 3), and the picture's depth."""

    corners: NDArray[np.float32]
    height: NDArray[np.float32]
    colors: NDArray[np.float32]
    depth: DepthPicture


def render(
    ax: Axes,
    vertices: ArrayLike,
    triangles: ArrayLike,
    *,
    camera: Camera,
    colors: ArrayLike | None = None,
    cmap: str | Colormap = "viridis",
    norm: Normalize | None = None,
    lines: ArrayLike | None = None,
    line_colors: ArrayLike | str = "#1c2733",
    line_width: float = 0.5,
) -> None:
    """Paint a shaded mesh, with lines that the mesh hides where it lies in front of them.

    Parameters
    ----------
    ax
        Axes of a figure; its limits become the camera's window and its frame is switched off.
    vertices : (n, 3) array, in any unit.
    triangles : (m, 3) array of rows of `vertices`, counter-clockwise seen from outside.
    camera
        From `subdfit.draw.camera.camera_for`.
    colors
        ``None`` for plaster; one colour (name or (3,)); (m, 3) colours a face; or (n,) numbers a vertex, coloured
        by `cmap` and `norm` (their full range when ``None``).
    lines : (k, 2, 3) segments in space, or ``None``.
    line_colors : one colour, or (k, 3).
    line_width : in points.

    Raises
    ------
    InputError
        When `colors` fit neither the faces nor the vertices.
    """
    points, faces = np.asarray(vertices, np.float64), np.asarray(triangles, np.int64)
    albedo = _albedo(colors, len(points), faces, cmap, norm)
    sheet = _sheet(points, faces, albedo, camera, _pixels(ax))
    strokes, stroke_height, stroke_colors = _strokes(lines, line_colors, camera, sheet)
    order = np.argsort(np.concatenate([sheet.height, stroke_height]), kind="stable")
    paint = np.concatenate([sheet.colors, stroke_colors])[order]
    widths = np.repeat([_SEAM, line_width], [len(sheet.height), len(strokes)])[order] if len(strokes) else _SEAM
    shapes: Any = np.concatenate([sheet.corners, strokes])[order]
    ax.add_collection(
        PolyCollection(shapes, facecolors=paint, edgecolors=paint, linewidths=widths, capstyle="round"),
        autolim=False,
    )
    left, right, bottom, top = camera.window
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_axis_off()


def _pixels(ax: Axes) -> int:
    """Return the number of pixels along the larger side of the axes."""
    return max(int(max(ax.bbox.width, ax.bbox.height)), 16)


def _albedo(
    colors: ArrayLike | None,
    vertex_count: int,
    faces: NDArray[np.int64],
    cmap: str | Colormap,
    norm: Normalize | None,
) -> NDArray[np.float32]:
    if colors is None or isinstance(colors, str):
        return np.tile(np.array(to_rgb(colors or PLASTER), np.float32), (len(faces), 1))
    given = np.asarray(colors)
    if given.shape == (3,) and vertex_count != 3:
        return np.tile(given.astype(np.float32), (len(faces), 1))
    if given.shape == (len(faces), 3):
        return given.astype(np.float32)
    if given.shape == (vertex_count,):
        values = given[faces].mean(axis=1)
        scale = norm or Normalize(float(given.min()), float(given.max()))
        palette = colormaps[cmap] if isinstance(cmap, str) else cmap
        return np.asarray(palette(scale(values)))[:, :3].astype(np.float32)
    raise InputError(
        f"colors of shape {given.shape} fit neither {vertex_count} vertices nor {len(faces)} triangles: "
        "give (n,) numbers or (m, 3) colours"
    )


def _sheet(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    albedo: NDArray[np.float32],
    camera: Camera,
    pixels: int,
) -> _Sheet:
    """Project, cull, shade; of crowded meshes keep what is larger than a pixel."""
    closed = is_closed(faces)
    if closed and signed_volume(points - camera.centre, faces) < 0.0:
        faces = faces[:, ::-1]
    seen = camera.project(points)
    depth = DepthPicture(seen, camera.window, pixels // 2)
    front = _turns_to_viewer(seen, faces)
    shown = front if closed else ~depth.hides(seen)[faces].all(axis=1)
    normals = smooth_normals(points - camera.centre, faces)[shown] @ camera.rotation.T.astype(np.float32)
    faces, albedo, back = faces[shown], albedo[shown], ~front[shown]
    normals[back] *= -1.0
    albedo = np.where(back[:, None], albedo * _INSIDE, albedo)
    colors = lit(normals, albedo, depth.openness(seen)[faces].mean(axis=1))
    if len(faces) > _MANY:
        faces, colors = _merge_pixels(seen, faces, colors, camera, pixels)
    corners = seen[faces]
    return _Sheet(corners[:, :, :2], corners[:, :, 2].mean(axis=1), colors, depth)


def _turns_to_viewer(seen: NDArray[np.float32], faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    a, b, c = (seen[faces[:, corner], :2] for corner in range(3))
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] > u[:, 1] * v[:, 0])


def _merge_pixels(
    seen: NDArray[np.float32],
    faces: NDArray[np.int64],
    colors: NDArray[np.float32],
    camera: Camera,
    pixels: int,
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Let one vertex stand for all in its cube of a pixel's size; triangles that collapse are dropped, no gap opens."""
    left, right, bottom, top = camera.window
    cell = max(right - left, top - bottom) / pixels
    cube = np.floor(seen / cell).astype(np.int64)
    cube -= cube.min(axis=0)
    extent = cube.max(axis=0) + 1
    key = (cube[:, 0] * extent[1] + cube[:, 1]) * extent[2] + cube[:, 2]
    _, first, member = np.unique(key, return_index=True, return_inverse=True)
    merged = first[member][faces]
    kept = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    return merged[kept], colors[kept]


def _strokes(
    lines: ArrayLike | None, line_colors: ArrayLike | str, camera: Camera, sheet: _Sheet
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Return segments as flat triangles (a, b, b), lifted to the viewer by the size of the triangles they lie on."""
    segments = np.empty((0, 2, 3)) if lines is None else np.asarray(lines, np.float64)
    ends = camera.project(segments.reshape(-1, 3)).reshape(-1, 2, 3)
    lift = np.float32(0.0)
    if len(sheet.corners):
        sides = np.ptp(sheet.corners, axis=1).max(axis=1)
        lift = np.float32(max(np.quantile(sides, 0.9), 1e-3 * camera.distance))
    given = to_rgb(line_colors) if isinstance(line_colors, str) else line_colors
    paint = np.broadcast_to(np.asarray(given, np.float32), (len(ends), 3))
    visible = ~sheet.depth.hides(ends.reshape(-1, 3)).reshape(-1, 2).all(axis=1)
    flat = ends[visible][:, [0, 1, 1]]
    return flat[:, :, :2], flat[:, :2, 2].mean(axis=1) + lift, paint[visible]

"""Shaded triangles and lines on a matplotlib axes: what is nearest is seen, without a display or a graphics card."""

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, Normalize, to_rgb
from numpy.typing import ArrayLike, NDArray

from subdfit.draw.camera import Camera
from subdfit.draw.depth import SAMPLES, DepthPicture, Grid
from subdfit.draw.shading import is_closed, lit, openness, signed_volume, smooth_normals
from subdfit.errors import InputError

PLASTER = (0.89, 0.875, 0.85)
"""Colour of a surface for which none is given."""

_INSIDE = np.array([0.62, 0.68, 0.78], np.float32)
"""Tint of the inner side of an open surface."""

_SHADOW_CELL = 2
"""Side in pixels of the cells in which shadows are found."""


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
    line_anchors: ArrayLike | None = None,
) -> None:
    """Paint a shaded mesh, and of lines what the mesh does not hide.

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
    line_anchors
        (k, 2, 3) places on the mesh: a line that lies off it is seen where these are. ``None`` is the lines themselves.

    Raises
    ------
    InputError
        When `colors` fit neither the faces nor the vertices.
    """
    points, faces = np.asarray(vertices, np.float64), np.asarray(triangles, np.int64)
    albedo = _albedo(colors, len(points), faces, cmap, norm)
    grid = _pixel_grid(ax, camera)
    depth, paint = _shade(points, faces, albedo, camera, grid)
    ax.imshow(depth.colored(paint), extent=grid.extent, origin="lower", interpolation="nearest")
    if lines is not None:
        given = to_rgb(line_colors) if isinstance(line_colors, str) else line_colors
        segments = np.asarray(lines, np.float64)
        anchors = segments if line_anchors is None else np.asarray(line_anchors, np.float64)
        pieces, row = _seen_pieces(segments, anchors, camera, grid, depth)
        ink = np.broadcast_to(np.asarray(given, np.float64), (len(segments), 3))[row]
        ax.add_collection(LineCollection(list(pieces), colors=ink, linewidths=line_width, capstyle="round"), False)


def _pixel_grid(ax: Axes, camera: Camera) -> Grid:
    """Fit the axes to the camera's window, and return the samples of the pixels that it touches."""
    left, right, bottom, top = camera.window
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")
    ax.set_axis_off()
    ax.apply_aspect()
    low, high = np.floor(ax.bbox.min), np.ceil(ax.bbox.max)
    pixel = (right - left) / ax.bbox.width
    x, y = np.array([left, bottom]) + (low - ax.bbox.min) * pixel
    columns, rows = SAMPLES * (high - low).astype(int)
    return Grid(float(x), float(y), pixel / SAMPLES, int(rows), int(columns))


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


def _shade(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    albedo: NDArray[np.float32],
    camera: Camera,
    grid: Grid,
) -> tuple[DepthPicture, NDArray[np.float32]]:
    """Return what is seen of the faces that may be, and their colours."""
    closed = is_closed(faces)
    if closed and signed_volume(points - camera.centre, faces) < 0.0:
        faces = faces[:, ::-1]
    seen = camera.project(points)
    normals = smooth_normals(points - camera.centre, faces) @ camera.rotation.T.astype(np.float32)
    front = _turns_to_viewer(seen, faces)
    if closed:
        faces, albedo, normals, front = faces[front], albedo[front], normals[front], front[front]
    depth = DepthPicture(seen, faces, camera, grid)
    normals[~front] *= -1.0
    albedo = np.where(front[:, None], albedo, albedo * _INSIDE)
    shadow_cells = max(grid.rows, grid.columns) // (SAMPLES * _SHADOW_CELL)
    return depth, lit(normals, albedo, openness(seen, camera.window, shadow_cells)[faces].mean(axis=1))


def _turns_to_viewer(seen: NDArray[np.float32], faces: NDArray[np.int64]) -> NDArray[np.bool_]:
    a, b, c = (seen[faces[:, corner], :2] for corner in range(3))
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] > u[:, 1] * v[:, 0])


def _seen_pieces(
    segments: NDArray[np.float64], anchors: NDArray[np.float64], camera: Camera, grid: Grid, depth: DepthPicture
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return what is seen of segments, (p, 2, 2) on the picture, and the row of the segment of each piece."""
    ends, places = (camera.project(s.reshape(-1, 3)).reshape(-1, 2, 3).astype(np.float64) for s in (segments, anchors))
    places[:, :, 2] = camera.nearness(places[:, :, 2])
    lengths = np.linalg.norm(ends[:, 1, :2] - ends[:, 0, :2], axis=1)
    count = np.clip(np.ceil(lengths / grid.cell), 1, grid.rows + grid.columns).astype(np.int64)
    row = np.repeat(np.arange(len(ends)), count)
    first = np.cumsum(count) - count
    step = np.arange(len(row)) - first[row]
    middles = _between(places, row, (step + 0.5) / count[row])
    middles[:, 2] = camera.height(middles[:, 2])
    shown = ~depth.hides(middles)
    # Runs of pieces of one segment that are seen become one.
    begins = shown & ((step == 0) | ~np.roll(shown, 1))
    stops = shown & ((step == count[row] - 1) | ~np.roll(shown, -1))
    row, stretch = row[begins], (step[begins], step[stops] + 1)
    return np.stack([_between(ends, row, at / count[row])[:, :2] for at in stretch], axis=1), row


def _between(ends: NDArray[np.float64], row: NDArray[np.int64], t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points at parameters from 0 to 1 on the segments of some rows."""
    return np.asarray(ends[row, 0] + t[:, None] * (ends[row, 1] - ends[row, 0]))

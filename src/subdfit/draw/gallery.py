"""Rows of shaded panels with captions, as papers and manuals show them."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.colors import Colormap, Normalize
from numpy.typing import ArrayLike

from subdfit.draw.camera import Camera, camera_for
from subdfit.draw.page import axes_at, new_figure, text_at, write_png
from subdfit.draw.render import render
from subdfit.errors import InputError

_GAP, _CAPTION_LINE, _TITLE = 0.12, 0.19, 0.45
"""Inches: space between panels, height of a line of caption, height of the title."""


@dataclass(frozen=True)
class Panel:
    """One picture of a gallery; the attributes are those of `subdfit.draw.render.render`.

    Attributes
    ----------
    caption : text below the panel, may have several lines.
    camera : ``None`` looks at this panel as at the first one.
    """

    vertices: ArrayLike
    triangles: ArrayLike
    caption: str = ""
    colors: ArrayLike | str | None = None
    cmap: str | Colormap = "viridis"
    norm: Normalize | None = None
    lines: ArrayLike | None = None
    line_colors: ArrayLike | str = "#1c2733"
    line_width: float = 0.5
    line_anchors: ArrayLike | None = None
    camera: Camera | None = None


def gallery(
    path: str | Path,
    panels: Sequence[Panel],
    *,
    columns: int | None = None,
    title: str = "",
    panel_width: float = 3.4,
) -> None:
    """Write a PNG with the panels in rows.

    Parameters
    ----------
    path
        The PNG; written whole or not at all.
    panels : from left to right, then down.
    columns : panels in a row; ``None`` puts up to five in one row, else four.
    title : one line over all.
    panel_width : inches.

    Raises
    ------
    InputError
        There is no panel, or one without triangles or with colours that do not fit it.
    MachineError
        The file cannot be written.
    """
    if len(panels) == 0:
        raise InputError("a gallery needs at least one panel")
    across = columns or (len(panels) if len(panels) <= 5 else 4)
    first = panels[0].camera or camera_for(panels[0].vertices, panels[0].triangles)
    rows = [panels[start : start + across] for start in range(0, len(panels), across)]
    heights = [_height(row, first, panel_width) for row in rows]
    foot = [
        0.12 + _CAPTION_LINE * max(panel.caption.count("\n") + bool(panel.caption) for panel in row) for row in rows
    ]
    top = sum(heights) + sum(foot) + _GAP
    figure = new_figure(across * (panel_width + _GAP) + _GAP, top + (_TITLE if title else 0.0))
    if title:
        text_at(figure, figure.get_size_inches()[0] / 2, top + _TITLE - 0.1, title, size=13, bold=True)
    for row, height, below in zip(rows, heights, foot, strict=True):
        top -= height
        for k, panel in enumerate(row):
            left = _GAP + k * (panel_width + _GAP)
            render(
                axes_at(figure, left, top, panel_width, height),
                panel.vertices,
                panel.triangles,
                camera=panel.camera or first,
                colors=panel.colors,
                cmap=panel.cmap,
                norm=panel.norm,
                lines=panel.lines,
                line_colors=panel.line_colors,
                line_width=panel.line_width,
                line_anchors=panel.line_anchors,
            )
            text_at(figure, left + panel_width / 2, top - 0.05, panel.caption, size=9)
        top -= below
    write_png(path, figure)


def _height(row: Sequence[Panel], first: Camera, width: float) -> float:
    tallest = max(width / (panel.camera or first).aspect for panel in row)
    return float(np.clip(tallest, 0.4 * width, 1.6 * width))

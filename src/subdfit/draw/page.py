"""From a figure to a file: inches, captions, and PNG bytes without a time stamp."""

import io
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from subdfit.io.atomic import atomic

DPI = 150

INK = "#22303c"
"""Colour of text and axes."""


def new_figure(width: float, height: float) -> Figure:
    """Return a white figure of that many inches, tied to the Agg canvas and to nothing global."""
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def axes_at(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Return new axes at a place given in inches from the figure's lower left corner."""
    across, up = figure.get_size_inches()
    return figure.add_axes((left / across, bottom / up, width / across, height / up))


def text_at(figure: Figure, x: float, y: float, text: str, *, size: float = 9.5, bold: bool = False) -> None:
    """Write lines of centred text, the first just below a place in inches; equal places give equal baselines."""
    across, up = figure.get_size_inches()
    weight = "bold" if bold else "normal"
    for k, line in enumerate(text.split("\n")):
        baseline = y - (1.0 + 1.45 * k) * size / 72.0
        figure.text(x / across, baseline / up, line, ha="center", va="baseline", size=size, weight=weight, color=INK)


def png(figure: Figure) -> bytes:
    """Return the figure as PNG; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI, bbox_inches=None, metadata={"Software": None})
    return buffer.getvalue()


def write_png(path: str | Path, figure: Figure) -> None:
    """Write the figure whole or not at all; raises MachineError where the file cannot be written."""
    data = png(figure)
    with atomic(path) as stream:
        stream.write(data)

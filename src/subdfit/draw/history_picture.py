"""How a fit converged: errors, control vertices and time over the iterations."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from subdfit.draw.error_scale import percent
from subdfit.draw.page import INK, axes_at, new_figure, text_at, write_png
from subdfit.errors import InputError

_CURVES = (("max", "$E_{max}$", "#c2412d"), ("rms", "$E_{rms}$", "#8a8f98"), ("mean", "$E_{mean}$", "#2b6ca3"))

_COLUMN = 7.4
"""Inches: width of a history."""

History = Sequence[Mapping[str, float]]


def history_picture(path: str | Path, history: History, *, title: str = "", tolerance: float | None = None) -> None:
    """Write a PNG of the convergence, after Nishiyama et al. 2008, Figure 5.

    Parameters
    ----------
    path
        The PNG; written whole or not at all.
    history
        One mapping an iteration: ``iteration``, ``control_vertices``, ``max``, ``rms``, ``mean`` (fractions of the
        diagonal) and ``seconds`` since the start.
    title : one line over the picture.
    tolerance : the largest error allowed, as a fraction of the diagonal, drawn as a level line; or None.

    Raises
    ------
    InputError
        The history is empty.
    MachineError
        The file cannot be written.
    """
    histories_picture(path, [(title, history)], tolerance=tolerance)


def histories_picture(
    path: str | Path, histories: Sequence[tuple[str, History]], *, tolerance: float | None = None
) -> None:
    """Write a PNG of several histories, each with its title, beside each other at one scale; see `history_picture`."""
    if any(len(history) == 0 for _, history in histories):
        raise InputError("an empty history cannot be drawn: give at least one iteration")
    titled = any(title for title, _ in histories)
    figure = new_figure(_COLUMN * len(histories), 6.0 if titled else 5.6)
    drawn = []
    for k, (title, history) in enumerate(histories):
        left = _COLUMN * k
        drawn.append(_draw_column(figure, left, history, tolerance))
        text_at(figure, left + 3.8, 5.82, title, size=12, bold=True)
    for row in zip(*drawn, strict=True):
        low, high = np.transpose([axes.get_ylim() for axes in row])
        for axes in row:
            axes.set_ylim(low.min(), high.max())
    for (_, history), (errors, *_) in zip(histories, drawn, strict=True):
        _name_curves(errors, history[-1])
    write_png(path, figure)


def _draw_column(figure: Figure, left: float, history: History, tolerance: float | None) -> tuple[Axes, Axes, Axes]:
    """Draw one history: errors, control vertices, seconds."""
    columns = {
        name: np.array([float(step[name]) for step in history])
        for name in ("iteration", "control_vertices", "max", "rms", "mean", "seconds")
    }
    errors = axes_at(figure, left + 0.95, 2.75, 5.7, 2.65)
    vertices = axes_at(figure, left + 0.95, 1.65, 5.7, 0.9)
    seconds = axes_at(figure, left + 0.95, 0.55, 5.7, 0.9)
    _draw_errors(errors, columns, tolerance)
    vertices.step(columns["iteration"], columns["control_vertices"], where="mid", color=INK, linewidth=1.4)
    vertices.set_ylabel("control\nvertices", size=9)
    seconds.bar(columns["iteration"], np.diff(columns["seconds"], prepend=0.0), width=0.62, color="#7fa8c9")
    seconds.set_ylabel("seconds an\niteration", size=9)
    seconds.set_xlabel("iteration", size=9.5)
    for axes in (errors, vertices, seconds):
        _tidy(axes, columns["iteration"], last=axes is seconds)
    return errors, vertices, seconds


def _draw_errors(axes: Axes, columns: Mapping[str, np.ndarray], tolerance: float | None) -> None:
    """Draw the error curves on a logarithmic axis, each named at its right end."""
    axes.set_yscale("log")
    steps = columns["iteration"]
    for name, _, color in _CURVES:
        values = np.where(columns[name] > 0.0, 100.0 * columns[name], np.nan)
        axes.plot(steps, values, color=color, linewidth=1.8, marker="o", markersize=3)
    if tolerance is not None:
        label = f"tolerance {percent(tolerance)}"
        axes.axhline(100.0 * tolerance, color=INK, linewidth=0.9, linestyle=(0, (4, 3)), label=label)
        axes.legend(loc="upper right", frameon=False, fontsize=8.5, labelcolor=INK)
    axes.set_ylabel("error, % of the diagonal", size=9)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.3g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _name_curves(axes: Axes, ends: Mapping[str, float]) -> None:
    """Write the curves' names outside the right border, where they end, moved apart where they would touch."""
    low, high = np.log(axes.get_ylim())
    last = [100.0 * float(ends[name]) for name, _, _ in _CURVES]
    places = [(np.log(value) - low) / (high - low) if value > 0.0 else 0.0 for value in last]
    below = 2.0
    for place, (_, label, color) in sorted(zip(places, _CURVES, strict=True), key=lambda pair: -pair[0]):
        below = min(place, below - 0.075)
        axes.annotate(label, (1.015, below), xycoords="axes fraction", va="center", size=10.5, color=color)


def _tidy(axes: Axes, steps: np.ndarray, *, last: bool) -> None:
    """Common x range, whole numbers, a faint grid, and no needless frame."""
    axes.set_xlim(steps[0] - 0.5, steps[-1] + 0.5)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(labelsize=8.5, color=INK, labelcolor=INK, labelbottom=last)
    axes.grid(axis="y", color="#e3e6e9", linewidth=0.7)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if axes.get_yscale() == "linear":
        axes.set_ylim(bottom=0.0)
        axes.yaxis.set_major_locator(MaxNLocator(3))

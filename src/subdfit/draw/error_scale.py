"""Colours for distances: calm within the tolerance, warm outside, and the bar that explains them."""

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from subdfit.draw.page import INK

_WITHIN = ("#f3f1e7", "#b9d7cf", "#6fb1bd", "#2f7fa6", "#1d4f85")
_BEYOND = ("#f6c244", "#ee7d2b", "#cf2f22", "#8e0f3c")
_BELOW = ("#cdb7e3", "#8d62b5", "#54207f")
"""From no error to the tolerance, beyond it, and (signed) beyond it to the inside."""

_CUT = 4.0
"""The scale ends at this many tolerances at most; worse errors share its last colour."""


@dataclass(frozen=True)
class ErrorScale:
    """How distances, as fractions of the diagonal, become colours.

    Attributes
    ----------
    cmap, norm : for `subdfit.draw.render.render`.
    tolerance : the distance marked on the bar, or None.
    largest : the largest distance shown, without its sign.
    """

    cmap: Colormap
    norm: Normalize
    tolerance: float | None
    largest: float

    @property
    def signed(self) -> bool:
        """Whether distances to the inside count as negative."""
        return bool(self.norm.vmin is not None and self.norm.vmin < 0.0)


def error_scale(errors: NDArray[np.floating], tolerance: float | None = None) -> ErrorScale:
    """Return the scale for errors (n,), fractions of the diagonal; signed when one of them is negative."""
    largest = float(np.abs(errors).max(initial=0.0))
    end = largest if tolerance is None else max(tolerance, min(largest, _CUT * tolerance))
    end = max(end, float(np.finfo(np.float32).tiny))
    signed = bool(np.any(errors < 0.0))
    share = 1.0 if tolerance is None else tolerance / end
    return ErrorScale(_colormap(share, signed), Normalize(-end if signed else 0.0, end), tolerance, largest)


def _colormap(share: float, signed: bool) -> Colormap:
    """Return the map whose inner `share` is within the tolerance."""
    stops = _stops(0.0, share, _WITHIN) + (_stops(share, 1.0, _BEYOND) if share < 1.0 else [])
    if signed:
        beyond = _stops(-share, -1.0, _BELOW) if share < 1.0 else []
        inner = _stops(0.0, -share, (_WITHIN[0], "#d8cfc0", "#a99f86", "#7b8a52", "#3f6b35"))
        stops = beyond[::-1] + inner[:0:-1] + stops
        stops = [((at + 1.0) / 2.0, color) for at, color in stops]
    return LinearSegmentedColormap.from_list("error", stops, N=1024)


def _stops(begin: float, end: float, colors: tuple[str, ...]) -> list[tuple[float, str]]:
    return list(zip(np.linspace(begin, end, len(colors)).tolist(), colors, strict=True))


def error_bar(figure: Figure, cax: Axes, scale: ErrorScale, diagonal: float, unit: str | None) -> None:
    """Draw the colour bar: per cent of the diagonal on its left, the model's unit on its right."""
    end = float(scale.norm.vmax or 1.0)
    mappable = ScalarMappable(Normalize(100.0 * float(scale.norm.vmin or 0.0), 100.0 * end), scale.cmap)
    beyond = scale.largest > end * (1.0 + 1e-9)
    extend = ("both" if scale.signed else "max") if beyond else "neither"
    bar = figure.colorbar(mappable, cax=cax, extend=extend, extendfrac=0.03)
    bar.outline.set_linewidth(0.6)
    cax.yaxis.set_ticks_position("left")
    cax.yaxis.set_label_position("left")
    cax.set_ylabel("distance, % of the diagonal", size=8.5, color=INK)
    factor = diagonal / 100.0
    there_and_back = (lambda p: np.asarray(p, np.float64) * factor, lambda q: np.asarray(q, np.float64) / factor)
    lengths = cax.secondary_yaxis("right", functions=there_and_back)
    lengths.set_ylabel(unit or "model's unit", size=8.5, color=INK)
    for axis in (cax, lengths):
        axis.tick_params(labelsize=8, width=0.6, length=3, color=INK, labelcolor=INK)
    if scale.tolerance is not None:
        for mark in (scale.tolerance, -scale.tolerance) if scale.signed else (scale.tolerance,):
            cax.axhline(100.0 * mark, color="black", linewidth=2.0)
        label = f"tolerance\n{percent(scale.tolerance)}"
        cax.set_title(f"▬ {label}", size=8.5, color=INK, pad=9)


def percent(fraction: float, digits: int = 3) -> str:
    """Return a fraction as text in per cent."""
    return f"{100.0 * fraction:.{digits}g} %"

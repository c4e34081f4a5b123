"""Data points that may be left out of the errors of a noisy scan."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

NORMAL_MEDIAN = 1.4826
"""The standard deviation of normal errors is so many medians of their sizes."""

GROSS = 4.0
"""Standard deviations, robustly estimated, beyond which a point is an outlier where no largest error is asked."""


@dataclass(frozen=True)
class Outliers:
    """What may be left out: a share of the points, of those beyond a bound; see `outliers`."""

    share: float = 0.0
    bound: float | None = None


NO_OUTLIERS = Outliers()


def outliers(distance: Floats, share: float, bound: float | None) -> Rows:
    """Rows of the worst points that lie beyond `bound`, ascending; at most `share` of all.

    Parameters
    ----------
    distance : (n,) float64.
    share : from 0 to less than 1; 0 leaves out nothing.
    bound : the largest error that is asked; None takes `GROSS` standard deviations.
    """
    far, most = far_points(distance, bound), int(share * len(distance))
    return np.sort(far[np.argsort(-distance[far], kind="stable")[:most]])


def far_points(distance: Floats, bound: float | None) -> Rows:
    """Rows of the points beyond the bound, as `outliers` takes it."""
    if bound is None:
        bound = GROSS * NORMAL_MEDIAN * float(np.median(distance))
    return np.flatnonzero(distance > bound)

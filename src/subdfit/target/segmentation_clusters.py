"""First steps of segmentation: classes of equal curvature, and the connected regions that they form."""

import numpy as np
from numpy.typing import NDArray

from subdfit.target.segmentation_facets import Facets, Labels

Floats = NDArray[np.float64]

_ITERATIONS = 50


def cluster(values: Floats, weights: Floats, count: int) -> Labels:
    """Classes (m,) of values (m, d) by weighted k-means (Lloyd 1982).

    It starts from the value nearest to the mean and then, `count` - 1 times, from the value farthest from those
    chosen (Gonzalez 1985): the same input gives the same classes.

    Parameters
    ----------
    values : (m, d) float64.
    weights : (m,) float64, such as the triangles' areas.
    count : the largest number of classes.
    """
    mean = weights @ values / weights.sum()
    centres = [values[np.argmin(_squares(values, mean))]]
    nearest = _squares(values, centres[0])
    while len(centres) < count and nearest.max() > 0.0:
        centres.append(values[np.argmax(nearest)])
        nearest = np.minimum(nearest, _squares(values, centres[-1]))
    middle = np.array(centres)
    classes = _nearest(values, middle)
    for _ in range(_ITERATIONS):
        mass = np.bincount(classes, weights, len(middle))
        sums = [np.bincount(classes, weights * column, len(middle)) for column in values.T]
        filled = mass > 0.0
        middle[filled] = np.stack(sums, axis=1)[filled] / mass[filled, None]
        before, classes = classes, _nearest(values, middle)
        if np.array_equal(before, classes):
            break
    return classes


def _squares(values: Floats, centre: Floats) -> Floats:
    return np.asarray(np.sum((values - centre) ** 2, axis=1))


def _nearest(values: Floats, centres: Floats) -> Labels:
    return np.asarray(np.argmin([_squares(values, centre) for centre in centres], axis=0), np.int64)


def grow(facets: Facets, classes: Labels) -> Labels:
    """Regions (m,): the connected parts of triangles of one class, not joined across sharp edges."""
    return facets.connected(~facets.sharp & ~facets.borders(classes))

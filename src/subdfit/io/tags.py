"""Creases, corners and the boundary rule, as OpenSubdiv counts sharpness."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh.data import SHARP_FOR_EVER


def finite_sharpness(sharpness: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sharpness as files hold it: everything that is sharp for ever is written as 10."""
    return np.minimum(sharpness, SHARP_FOR_EVER)


def boundary_rule(value: Any, name: str) -> int | None:
    """Return 0, 1, 2 or None; raises InputError for anything else."""
    if value is None:
        return None
    if type(value) is not int or value not in (0, 1, 2):
        raise InputError(f"{name}: interpolateboundary is {value!r}; it must be 0, 1 or 2")
    return value

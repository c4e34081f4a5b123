"""A rehearsal: a small fit, made only so that the kernels that every fit needs are compiled and kept."""

import numpy as np
from numpy.typing import NDArray

from subdfit.api.cages import control_mesh_of
from subdfit.api.fitting import fit
from subdfit.api.measuring import measure
from subdfit.api.targets import Preparation, prepare
from subdfit.fit.adapt import refined
from subdfit.fit.data import FitData
from subdfit.fit.state import FitState
from subdfit.limit.surface import LimitSurface

Sheet = tuple[NDArray[np.float64], NDArray[np.int64]]


def rehearse(scheme: str) -> None:
    """Fit a small wavy sheet by a scheme, not in a fit's order.

    A fit that runs meanwhile compiles what its start needs. This begins with the limit surface, footpoints and
    refinement, and what is left is done last.
    """
    coarse, fine = _wavy_sheet(3), _wavy_sheet(24)
    _refine_once(coarse, fine, scheme)
    measure(coarse, fine, scheme=scheme, threads=1)
    fit(fine, scheme=scheme, max_error="0.05%", max_control_vertices=60, threads=1)


def _refine_once(coarse: Sheet, fine: Sheet, scheme: str) -> None:
    """Find footpoints of the fine sheet, all from one face of the coarse one, and refine that with them."""
    data = FitData.of(prepare(fine, Preparation()).target, spacing=1.0)
    surface = LimitSurface(control_mesh_of(coarse, scheme))
    everywhere = np.ones(len(surface.topology.face_vertices), np.bool_)
    count = len(data.points)
    refined(FitState.follow(data, surface, np.zeros(count, np.int32), np.full((count, 2), 0.3)), everywhere)


def _wavy_sheet(cells: int) -> Sheet:
    """So many squares a side, each cut into two triangles."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, cells + 1), np.linspace(0.0, 1.0, cells + 1), indexing="ij")
    points = np.stack([u, v, 0.2 * np.sin(5.0 * u) * np.cos(4.0 * v)], axis=-1).reshape(-1, 3)
    row, column = np.divmod(np.arange(cells * cells), cells)
    corner = row * (cells + 1) + column
    right, above = corner + cells + 1, corner + 1
    triangles = np.concatenate(
        [np.stack([corner, right, right + 1], axis=1), np.stack([corner, right + 1, above], axis=1)]
    )
    return points, triangles

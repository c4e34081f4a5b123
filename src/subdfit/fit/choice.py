"""Which method `auto` stands for: a part whose faces meet in sharp edges is best fitted from these faces and edges."""

import numpy as np

from subdfit.errors import InputError
from subdfit.fit.lavoue_whole import cut_part
from subdfit.fit.settings import FitSettings
from subdfit.target.target import Target

SHARP = 2 / 3
"""Share of the borders between faces that are sharp edges, from which a part is one of sharp edges."""


def suits_lavoue(target: Target, settings: FitSettings) -> bool:
    """Whether a fit by `auto` is to be tried by `lavoue` first.

    So it is where the control mesh may have triangles and quads, nothing is said about how it begins, and most of the
    borders between the target's faces are sharp.
    """
    free = settings.control_vertices is None and not settings.fixed_boundary and settings.robust == 0
    if settings.scheme != "quad-triangle" or not free or target.cloud or len(target.crease_edges) == 0:
        return False
    try:
        cuts = cut_part(target).cuts
    except InputError:
        return False
    ends = target.points[cuts.edges]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return float(length[cuts.exact].sum()) >= SHARP * float(length.sum())

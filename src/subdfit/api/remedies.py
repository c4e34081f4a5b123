"""What may help a fit that is not certified, or only as far as a coarse mesh goes: one remedy, where it applies."""

import numpy as np

from subdfit.api.result import FitResult
from subdfit.target.curves import boundary_loops
from subdfit.target.features import crease_edges
from subdfit.target.target import Target
from subdfit.wording import counted

TURNED = "ask for a smaller error, start from more control vertices or close holes (--fill-holes)"
"""For a surface of which a part faces the wrong way, which a verdict on one within tolerance says."""

SHARP = 30.0
"""Degrees by which an edge bends that may be meant to be sharp."""
SPENT = 0.95
"""Share of the budget of control vertices from which a fit has run into it: no batch of splits fits into the rest."""
GRANTED = 1.0
"""Tolerances by which a certified surface may stray beyond its own, for the mesh's facets, before it is told."""
MANY_LOOPS, SHORT_LOOP = 12, 30
"""So many boundary loops of at most so many edges are the holes of a scan rather than a part's own."""


def remedy(result: FitResult) -> str | None:
    """The first remedy that applies to a fit; None where it was interrupted or none does."""
    if result.certified:
        return _of_coarse_facets(result)
    if result.status == "interrupted":
        return None
    target = result.target
    assert target is not None
    if result.status == "best_effort" and _worst_is_sharp(result, target):
        return f"if the edges that bend by more than {SHARP:.0f} degrees are sharp: --creases {SHARP:.0f}"
    if result.measurement.sheets_fell_together:
        return TURNED if result.status == "within_tolerance" else f"part of the surface faces the wrong way: {TURNED}"
    budget, data = result.settings.max_control_vertices or 0, len(target.used)
    spent = max(row.control_vertices for row in result.history) >= SPENT * budget > 0
    if spent and budget < data:
        return f"the budget of {counted(budget, 'control vertex')} is spent: allow more (--max-control-vertices)"
    loops = 0 if result.asked and result.asked["fill_holes"] else _short_loops(target)
    if loops >= MANY_LOOPS:
        return f"if the {loops} short boundary loops are holes: --fill-holes {SHORT_LOOP}"
    if spent:
        return f"{counted(data, 'data point')} allow no more control vertices: ask for a larger error or give more data"
    return None


def _of_coarse_facets(result: FitResult) -> str | None:
    """What helps where the surface strays further for the mesh's facets than was asked; None where it does not."""
    asked, target = result.settings.tolerance.max, result.target
    if asked is None or target is None or not target.is_mesh or target.cloud:
        return None
    granted = result.measurement.reverse_max - asked
    if granted <= GRANTED * asked:
        return None
    return (
        f"{100 * granted:.2g} % of the reverse error is granted to the mesh's facets: "
        "give a finer mesh, or name sharp edges (--creases)"
    )


def _worst_is_sharp(result: FitResult, target: Target) -> bool:
    """Whether the data point that is farthest off lies on an edge that could be a crease and is none."""
    if target.cloud or not target.is_mesh or len(target.crease_edges):
        return False
    distance = result.distances.copy()
    distance[result.measurement.excluded] = 0.0
    return bool(np.isin(target.used[np.argmax(distance)], crease_edges(target.points, target.triangles, SHARP)))


def _short_loops(target: Target) -> int:
    """Number of the target's short boundary loops; a cloud's are our own making."""
    if target.cloud or not target.is_mesh:
        return 0
    return sum(len(curve.vertices) <= SHORT_LOOP for curve in boundary_loops(target.triangles))

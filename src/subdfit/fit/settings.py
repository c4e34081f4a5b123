"""What a fit is asked to do."""

from dataclasses import dataclass, field

from subdfit.measure import Tolerance


@dataclass(frozen=True)
class FitSettings:
    """Settings of a fit; lengths are shares of the target's diagonal.

    Attributes
    ----------
    scheme : subdivision scheme by name.
    method : fitter by name, ``tangent``, ``geometric`` or ``lavoue``; ``auto`` is ``tangent``, or ``lavoue`` for parts
        with many sharp edges, and a result's settings then say ``lavoue``.
    tolerance : what must hold.
    control_vertices : vertices of the first control mesh; None chooses from the tolerance.
    max_control_vertices : budget; None is one a point of the target.
    robust : share of the data points that may be left out as outliers; 0 leaves out none.
    fixed_boundary : the boundary's curve is fitted first, by the data's boundary alone, and then held.
    thin : in the end remove control vertices and merge faces while the tolerance holds; ``lavoue`` does so anyway.
    max_iterations : after so many iterations the best so far is returned.
    sample_spacing : faces of the target with longer sides are sampled inside.
    over_relaxation : factor on the displacements of ``geometric`` (1 is the paper's).
    nesterov : accelerate ``geometric`` by Nesterov's momentum.
    boundary_step : boundary control vertices of ``geometric`` move by boundary data alone; not in the paper.
    """

    scheme: str = "loop"
    method: str = "auto"
    tolerance: Tolerance = field(default_factory=lambda: Tolerance(max=1e-3))
    control_vertices: int | None = None
    max_control_vertices: int | None = None
    robust: float = 0.0
    fixed_boundary: bool = False
    thin: bool = False
    max_iterations: int = 120
    sample_spacing: float = 0.02
    over_relaxation: float = 1.0
    nesterov: bool = False
    boundary_step: bool = True

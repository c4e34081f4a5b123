"""What `subdfit.interpolate` gives back."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.api.surface import LimitSurface
from subdfit.fit.result import mesh_counts
from subdfit.interpolate import Status
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.wording import counted


@dataclass(frozen=True, eq=False, repr=False)
class InterpolationResult:
    """The control mesh whose limit surface passes through given points.

    Attributes
    ----------
    control_mesh : in the coordinates and unit of `given`; its vertices are those of `given`, in their order, and after
        a fair interpolation those of one refinement follow.
    given : the mesh that was interpolated, with the creases that were taken.
    method : the solver.
    status : ``within_tolerance``, ``best_effort`` or ``interrupted``.
    residuals : at each iteration, the largest distance of a limit point from its vertex, as a share of the diagonal.
    distances : (n,), these distances in the end, computed afresh, as shares of the diagonal.
    null_vectors : number of independent control meshes that the scheme shrinks to nothing; 0 almost always.
    energy : thin-plate energy of the plain interpolation and of the fair one, in normalised coordinates, or None.
    diagonal : of the given mesh's bounding box.
    settings, seconds : what was asked; by stage.
    unit : its name, or None.
    """

    control_mesh: ControlMesh
    given: ControlMesh
    method: str
    status: Status
    residuals: tuple[float, ...]
    distances: NDArray[np.float64]
    null_vectors: int
    energy: tuple[float, float] | None
    diagonal: float
    settings: dict[str, Any]
    seconds: dict[str, float] = field(default_factory=dict)
    unit: str | None = None

    @cached_property
    def surface(self) -> LimitSurface:
        """The limit surface."""
        return LimitSurface(self.control_mesh)

    @property
    def iterations(self) -> int:
        """Number of iterations."""
        return len(self.residuals) - 1

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` writes; errors and residuals are shares of the diagonal.

        The surface between the vertices is not measured, so that nothing is certified.
        """
        from subdfit import __version__

        return {
            "scheme": self.control_mesh.scheme,
            "method": self.method,
            "status": self.status,
            "certified": False,
            "iterations": self.iterations,
            **mesh_counts(self.control_mesh),
            "diagonal": self.diagonal,
            "unit": self.unit,
            "errors": _errors(self.given.topology, self.distances),
            "null_vectors": self.null_vectors,
            "energy": self.energy and dict(zip(("plain", "fair"), self.energy, strict=True)),
            "seconds": self.seconds,
            "settings": self.settings,
            "version": __version__,
            "residuals": list(self.residuals),
        }

    def __repr__(self) -> str:
        return (
            f"<InterpolationResult {counted(len(self.distances), 'point')}, {self.status.replace('_', ' ')}: "
            f"largest relative error {self.distances.max():.2g}, {counted(self.iterations, 'iteration')}>"
        )


def _errors(t: Topology, distances: NDArray[np.float64]) -> dict[str, Any]:
    """The errors as ``--json`` names them; the reverse side is not measured."""
    return {
        "max": float(distances.max()),
        "rms": float(np.sqrt(np.mean(distances**2))),
        "mean": float(distances.mean()),
        "reverse_max": None,
        "reverse_rms": None,
        "reverse_mean": None,
        "boundary": _curve_errors(t, t.boundary_edges, distances),
        "crease": _curve_errors(t, (t.sharpness > 0) & ~t.boundary_edges, distances),
        "excluded": 0,
        "target_faceting": None,
    }


def _curve_errors(t: Topology, edges: NDArray[np.bool_], distances: NDArray[np.float64]) -> dict[str, float] | None:
    vertices = np.unique(t.edge_vertices[edges])
    if not len(vertices):
        return None
    return {"max": float(distances[vertices].max()), "mean": float(distances[vertices].mean())}

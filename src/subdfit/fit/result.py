"""What a fit gives back."""

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.settings import FitSettings
from subdfit.limit.surface import LimitSurface
from subdfit.measure import Measurement
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.wording import counted

Status = Literal["within_tolerance", "best_effort", "interrupted"]


@dataclass(frozen=True)
class Iteration:
    """One row of a fit's history; errors are shares of the diagonal, seconds count from the start of the fit, without
    compiling.
    """

    iteration: int
    control_vertices: int
    max: float
    rms: float
    mean: float
    seconds: float


@dataclass(frozen=True, eq=False)
class FitResult:
    """A fitted control mesh with its errors.

    Attributes
    ----------
    control_mesh : in the target's coordinates and unit.
    status : ``within_tolerance``, ``best_effort`` or ``interrupted``.
    certified : a final pass with fresh footpoints for every data point, and the reverse side, are within tolerance.
    measurement : that final pass.
    history : one row an iteration.
    settings : what was asked.
    seconds : by stage, ``total`` and ``compile`` among them.
    """

    control_mesh: ControlMesh
    status: Status
    certified: bool
    measurement: Measurement
    history: tuple[Iteration, ...]
    settings: FitSettings
    seconds: dict[str, float]
    unit: str | None = None

    @cached_property
    def surface(self) -> LimitSurface:
        """The limit surface, in the target's coordinates."""
        return LimitSurface(self.control_mesh, self.settings.scheme)

    @property
    def distances(self) -> NDArray[np.float64]:
        """Distance of every data point from the surface, in the target's unit, (k,)."""
        return self.measurement.footpoints.distance * self.measurement.diagonal

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` writes; errors are shares of the diagonal."""
        from subdfit import __version__

        return {
            "scheme": self.settings.scheme,
            "method": self.settings.method,
            "status": self.status,
            "certified": self.certified,
            "iterations": len(self.history),
            **mesh_counts(self.control_mesh),
            "diagonal": self.measurement.diagonal,
            "unit": self.unit,
            "errors": errors_dict(self.measurement),
            "seconds": self.seconds,
            "settings": asdict(self.settings),
            "version": __version__,
            "history": [asdict(row) for row in self.history],
        }

    def __str__(self) -> str:
        m, unit = self.measurement, self.unit or "units"
        word = "certified" if self.certified else self.status.replace("_", " ")
        return (
            f"{counted(self.control_mesh.topology.vertex_count, 'control vertex')}, {word}: "
            f"E_max {100 * m.max:.4f} % ({m.max * m.diagonal:.4g} {unit}), E_rms {100 * m.rms:.4f} %, "
            f"reverse {100 * m.reverse_max:.4f} %, {self.seconds['total']:.1f} s"
        )

    def __repr__(self) -> str:
        return f"<FitResult {self}>"

    def _repr_html_(self) -> str:
        m = self.measurement
        rows = [
            ("control vertices", f"{self.control_mesh.topology.vertex_count:,}"),
            ("status", "certified" if self.certified else self.status.replace("_", " ")),
            ("E_max", f"{100 * m.max:.4f} % = {m.max * m.diagonal:.4g} {self.unit or ''}"),
            ("E_rms", f"{100 * m.rms:.4f} %"),
            ("E_mean", f"{100 * m.mean:.4f} %"),
            ("reverse E_max", f"{100 * m.reverse_max:.4f} %"),
            ("iterations", str(len(self.history))),
            ("seconds", f"{self.seconds['total']:.2f}"),
        ]
        cells = "".join(f"<tr><th style='text-align:left'>{name}</th><td>{value}</td></tr>" for name, value in rows)
        return f"<table>{cells}</table>"


def mesh_counts(mesh: ControlMesh) -> dict[str, int]:
    """Counts of a control mesh as ``--json`` names them."""
    return {
        "control_vertices": mesh.topology.vertex_count,
        "control_faces": mesh.topology.face_count,
        "crease_edges": len(mesh.topology.crease_edges),
    }


def errors_dict(m: Measurement) -> dict[str, Any]:
    """The errors as ``--json`` names them."""
    return {
        "max": m.max,
        "rms": m.rms,
        "mean": m.mean,
        "reverse_max": m.reverse_max,
        "reverse_rms": m.reverse_rms,
        "reverse_mean": m.reverse_mean,
        "boundary": asdict(m.boundary) if m.boundary else None,
        "crease": asdict(m.crease) if m.crease else None,
        "excluded": len(m.excluded),
        "target_faceting": m.faceting,
    }

"""What `subdfit.fit` gives back: the fit, with its target, and all that was asked."""

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

from subdfit.api.surface import LimitSurface
from subdfit.fit import result as fit
from subdfit.target.target import Target


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(fit.FitResult):
    """A fitted control mesh with its errors.

    Attributes
    ----------
    control_mesh : in the target's coordinates and unit.
    status : ``within_tolerance``, ``best_effort`` or ``interrupted``.
    certified : a final pass with fresh footpoints for every data point, and the reverse side, are within tolerance.
    measurement : that final pass.
    history : one row an iteration.
    settings : what the fit was asked to do.
    seconds : by stage; ``total`` leaves out ``compile``.
    unit : the unit's name, or None.
    target : what was fitted, after mending; its `used` points are the rows of `distances`.
    asked : the arguments of `subdfit.fit` that are not in `settings`.
    """

    target: Target | None = None
    asked: dict[str, Any] | None = None

    @classmethod
    def of(cls, found: fit.FitResult, target: Target, asked: dict[str, Any], seconds: dict[str, float]) -> "FitResult":
        """Complete what the driver found; `seconds` replaces its own."""
        known = {field.name: getattr(found, field.name) for field in fields(found)}
        return cls(**known | {"seconds": seconds, "target": target, "asked": asked})

    @cached_property
    def surface(self) -> LimitSurface:
        """The limit surface, in the target's coordinates."""
        return LimitSurface(self.control_mesh, self.settings.scheme)

    def to_dict(self) -> dict[str, Any]:
        """The object that ``--json`` writes; errors are shares of the diagonal."""
        document = super().to_dict()
        settings = document["settings"]
        if self.settings.robust and self.target is not None:
            document["excluded_rows"] = self.target.used[self.measurement.excluded].tolist()
        return document | {"settings": tolerance_dict(settings.pop("tolerance")) | settings | (self.asked or {})}


def tolerance_dict(tolerance: dict[str, float | None]) -> dict[str, Any]:
    """Tolerances under their options' names, as shares of the diagonal."""
    return {f"{name}_error": share for name, share in tolerance.items()}

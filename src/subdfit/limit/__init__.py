"""The limit surface: exact evaluation, weights and tessellation, the same for every scheme."""

from subdfit.limit.surface import Evaluation, LimitSurface

__all__ = ["Evaluation", "LimitSurface"]

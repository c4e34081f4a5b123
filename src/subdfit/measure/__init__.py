"""Two-sided errors and the certificate."""

from subdfit.measure.certificate import CurveErrors, Measurement, Tolerance, measure, reverse_segments
from subdfit.measure.outliers import Outliers, far_points, outliers

__all__ = [
    "CurveErrors",
    "Measurement",
    "Outliers",
    "Tolerance",
    "far_points",
    "measure",
    "outliers",
    "reverse_segments",
]

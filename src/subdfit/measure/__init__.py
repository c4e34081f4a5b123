"""Two-sided errors and the certificate."""

from subdfit.measure.certificate import CurveErrors, Measurement, Tolerance, measure, reverse_peaks
from subdfit.measure.outliers import Outliers, far_points, outliers
from subdfit.measure.peaks import PEAK, peaks
from subdfit.measure.samples import reverse_segments, surface_samples

__all__ = [
    "PEAK",
    "CurveErrors",
    "Measurement",
    "Outliers",
    "Tolerance",
    "far_points",
    "measure",
    "outliers",
    "peaks",
    "reverse_peaks",
    "reverse_segments",
    "surface_samples",
]

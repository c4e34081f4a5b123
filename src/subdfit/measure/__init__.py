"""Two-sided errors and the certificate."""

from subdfit.measure.certificate import CurveErrors, Measurement, Tolerance, measure, reverse_segments

__all__ = ["CurveErrors", "Measurement", "Tolerance", "measure", "reverse_segments"]

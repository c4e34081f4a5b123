"""Two-sided errors and the certificate."""

from subdfit.measure.certificate import REVERSE_SEGMENTS, CurveErrors, Measurement, Tolerance, measure

__all__ = ["REVERSE_SEGMENTS", "CurveErrors", "Measurement", "Tolerance", "measure"]

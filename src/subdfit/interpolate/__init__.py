"""Interpolation: control points whose limit surface passes through given points, vertex by vertex."""

from subdfit.interpolate.driver import METHODS, Interpolation, Status, interpolate_points
from subdfit.interpolate.fair import Fair, fair_interpolation
from subdfit.interpolate.operator import LimitOperator

__all__ = ["METHODS", "Fair", "Interpolation", "LimitOperator", "Status", "fair_interpolation", "interpolate_points"]

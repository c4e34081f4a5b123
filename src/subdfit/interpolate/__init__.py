"""Interpolation: control points whose limit surface passes through given points, vertex by vertex."""

from subdfit.interpolate.driver import METHODS, Interpolation, Status, interpolate_points
from subdfit.interpolate.operator import LimitOperator

__all__ = ["METHODS", "Interpolation", "LimitOperator", "Status", "interpolate_points"]

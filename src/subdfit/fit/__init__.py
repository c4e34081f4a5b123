"""Fitting: the problem, the methods, adaptation, and the driver that runs them."""

from subdfit.fit.driver import METHODS, Progress, fit_target
from subdfit.fit.result import FitResult, Iteration
from subdfit.fit.settings import FitSettings

__all__ = ["METHODS", "FitResult", "FitSettings", "Iteration", "Progress", "fit_target"]

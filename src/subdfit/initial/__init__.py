"""The start: from a dense mesh to a clean one, and to the first, coarse control mesh."""

from subdfit.initial.components import KeptMesh, keep_components
from subdfit.initial.decimate import Decimated, decimate
from subdfit.initial.holes import FilledMesh, fill_holes

__all__ = ["Decimated", "FilledMesh", "KeptMesh", "decimate", "fill_holes", "keep_components"]

"""What users of the library call: each function composes the rooms below and adds nothing of its own."""

from subdfit.api.cages import control_mesh_of
from subdfit.api.converting import convert
from subdfit.api.files import read, write
from subdfit.api.fitting import fit
from subdfit.api.interpolating import interpolate
from subdfit.api.interpolation_result import InterpolationResult
from subdfit.api.measuring import Comparison, compare, measure
from subdfit.api.pictures import history_picture, picture
from subdfit.api.reconstructing import Reconstruction, reconstruct
from subdfit.api.result import FitResult
from subdfit.api.segmenting import Segmentation, segment
from subdfit.api.sources import mesh_data
from subdfit.api.subdividing import subdivide
from subdfit.api.surface import LimitSurface, Tessellation

__all__ = [
    "Comparison",
    "FitResult",
    "InterpolationResult",
    "LimitSurface",
    "Reconstruction",
    "Segmentation",
    "Tessellation",
    "compare",
    "control_mesh_of",
    "convert",
    "fit",
    "history_picture",
    "interpolate",
    "measure",
    "mesh_data",
    "picture",
    "read",
    "reconstruct",
    "segment",
    "subdivide",
    "write",
]

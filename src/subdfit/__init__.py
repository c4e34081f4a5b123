"""subdfit: subdivision surfaces fitted to dense meshes, with a certified error.

Everything named here is loaded when it is first used, so that importing the package costs nothing.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from subdfit.api import (
        FitResult,
        InterpolationResult,
        LimitSurface,
        Reconstruction,
        Segmentation,
        Tessellation,
        convert,
        fit,
        history_picture,
        interpolate,
        measure,
        picture,
        read,
        reconstruct,
        segment,
        subdivide,
        write,
    )
    from subdfit.closest.projection import Projection
    from subdfit.errors import InputError, MachineError, SubdfitError
    from subdfit.fit.driver import Progress
    from subdfit.limit.surface import Evaluation
    from subdfit.measure import Measurement
    from subdfit.mesh.control_mesh import ControlMesh
    from subdfit.mesh.data import MeshData

__version__ = "0.1.0"

_HOME = {
    "ControlMesh": "subdfit.mesh.control_mesh",
    "Evaluation": "subdfit.limit.surface",
    "FitResult": "subdfit.api",
    "InputError": "subdfit.errors",
    "InterpolationResult": "subdfit.api",
    "LimitSurface": "subdfit.api",
    "MachineError": "subdfit.errors",
    "Measurement": "subdfit.measure",
    "MeshData": "subdfit.mesh.data",
    "Progress": "subdfit.fit.driver",
    "Projection": "subdfit.closest.projection",
    "Reconstruction": "subdfit.api",
    "Segmentation": "subdfit.api",
    "SubdfitError": "subdfit.errors",
    "Tessellation": "subdfit.api",
    "convert": "subdfit.api",
    "fit": "subdfit.api",
    "history_picture": "subdfit.api",
    "interpolate": "subdfit.api",
    "measure": "subdfit.api",
    "picture": "subdfit.api",
    "read": "subdfit.api",
    "reconstruct": "subdfit.api",
    "segment": "subdfit.api",
    "subdivide": "subdfit.api",
    "write": "subdfit.api",
}
"""Where each public name lives."""

__all__ = [
    "ControlMesh",
    "Evaluation",
    "FitResult",
    "InputError",
    "InterpolationResult",
    "LimitSurface",
    "MachineError",
    "Measurement",
    "MeshData",
    "Progress",
    "Projection",
    "Reconstruction",
    "Segmentation",
    "SubdfitError",
    "Tessellation",
    "__version__",
    "convert",
    "fit",
    "history_picture",
    "interpolate",
    "measure",
    "picture",
    "read",
    "reconstruct",
    "segment",
    "subdivide",
    "write",
]


def __getattr__(name: str) -> Any:
    """Load a public name on its first use (PEP 562)."""
    if name not in _HOME:
        raise AttributeError(f"module 'subdfit' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)


class _Package(ModuleType):
    """Keeps `fit`, `interpolate` and `measure` functions, though rooms of these names exist.

    Importing a submodule would bind it as an attribute of the package and hide the public function.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __dir__() -> list[str]:
    return sorted(__all__)

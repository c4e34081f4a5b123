"""The saved run: a folder from which a fit can be looked at without its target."""

from pathlib import Path
from typing import TYPE_CHECKING

from subdfit.cli.outputs import made_folder, write_json

if TYPE_CHECKING:
    from subdfit import FitResult

CONTROL_MESH, DISTANCES, DOCUMENT = "control_mesh.json", "distances.npy", "run.json"
"""The control mesh; every data point's distance, (k,) float64, in the target's unit; the document of ``--json``."""


def check_run(folder: str | None) -> None:
    """Raise MachineError now where `write_run` could only fail at the end."""
    from subdfit.io.atomic import check_folder

    if folder is not None:
        check_folder(Path(folder) / DOCUMENT if Path(folder).is_dir() else folder)


def write_run(folder: str, result: "FitResult") -> None:
    """Write the folder's three files, each whole or not at all, the document last."""
    import numpy as np

    from subdfit import api
    from subdfit.io.atomic import atomic

    made = made_folder(folder)
    api.write(made / CONTROL_MESH, result.control_mesh)
    with atomic(made / DISTANCES) as stream:
        np.save(stream, result.distances)
    write_json(made / DOCUMENT, result.to_dict())

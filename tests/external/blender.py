"""Blender, in the Python that ``SUBDFIT_BLENDER`` names: what it says of cages, and what is stored of that."""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
STORED = HERE / "blender.npz"
VERSION = "5.0.1"
"""Blender that made the stored points."""


def ask(cages, quality=10):
    """Limit points of cages by name, as `blender_limits.py` writes them."""
    given = {}
    for name, cage in cages.items():
        t = cage.mesh.topology
        given[f"{name}/points"], given[f"{name}/offsets"] = cage.mesh.points, t.face_offsets
        given[f"{name}/corners"], given[f"{name}/keep_corners"] = t.face_vertices, np.array(cage.keep_corners)
        given[f"{name}/creases"], given[f"{name}/pinned"] = cage.creases, cage.pinned
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "cages.npz", Path(folder) / "limits.npz"
        np.savez(source, **given)
        call = [os.environ["SUBDFIT_BLENDER"], HERE / "blender_limits.py", source, target, str(quality)]
        subprocess.run(call, check=True, capture_output=True)
        with np.load(target) as found:
            return dict(found)

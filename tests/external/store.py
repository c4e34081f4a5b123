"""Write the sample of Blender's limit points that the tests compare with: ``python -m external.store MESHES``."""

import sys
from pathlib import Path

import numpy as np

from external.blender import STORED, VERSION, ask
from external.cases import CASES, rows_of, tagged

SAMPLE = 150


def main(meshes):
    """Ask Blender about all cases and keep some points of each."""
    cages = {name: tagged(case, Path(meshes)) for name, case in CASES.items()}
    found, out = ask(cages), {}
    if str(found["version"]) != VERSION:
        sys.exit(f"this is Blender {found['version']}; the sample is of {VERSION}")
    out["version"] = found["version"]
    for name, cage in cages.items():
        rows = rows_of(cage.mesh.topology, found[f"{name}/edges"])
        kept = np.random.default_rng(5).choice(len(rows), SAMPLE, replace=False)
        out[f"{name}/rows"], out[f"{name}/limits"] = rows[kept].astype(np.int32), found[f"{name}/limits"][kept]
    np.savez_compressed(STORED, **out)


main(*sys.argv[1:])

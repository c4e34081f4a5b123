"""``python -m benchmarks [SECTION ...]``: measure and print; without names, all sections but the slow ones."""

import sys

import subdfit
from benchmarks import (
    certificate,
    creases,
    dragon,
    interpolation,
    kernels,
    paper,
    parts,
    reconstruction,
    scaling,
    schemes,
    stages,
    subdivision,
)
from benchmarks.common import MODELS, machine

SECTIONS = {
    "paper": ("The paper's models, both methods", paper.run),
    "creases": ("Machined parts with and without creases", creases.run),
    "schemes": (f"All schemes at {schemes.BOUND}", schemes.run),
    "certificate": (f"What the certificate finds at {certificate.BOUND}", certificate.run),
    "stages": ("Where the time goes", stages.run),
    "scaling": ("How time grows", scaling.run),
    "kernels": ("Kernels", kernels.run),
    "subdivision": ("Subdivision", subdivision.run),
    "parts": ("Machined parts: curvature and faces", parts.run),
    "interpolation": ("Interpolation", interpolation.run),
    "reconstruction": ("Points", reconstruction.run),
    "dragon": ("The dragon", dragon.run),
    "million": ("Interpolation of a million vertices", interpolation.million),
}
SLOW = ("dragon", "million", "reconstruction")


def main(names: list[str]) -> int:
    """Run the named sections."""
    unknown = [name for name in names if name not in SECTIONS]
    if unknown:
        print(f"benchmarks: no section '{unknown[0]}'; choose from {', '.join(SECTIONS)}", file=sys.stderr)
        return 2
    if not MODELS.is_dir():
        print(f"benchmarks: no models in {MODELS}; set SUBDFIT_MESHES to their folder", file=sys.stderr)
        return 2
    subdfit.fit(MODELS / "cylinder.ply", max_error="0.5%")  # compile first
    subdfit.fit(MODELS / "cylinder.ply", max_error="0.5%", method="geometric")
    print(f"{machine()}\n")
    for name in names or [name for name in SECTIONS if name not in SLOW]:
        title, run = SECTIONS[name]
        print(f"### {title}\n\n{run()}\n", flush=True)
    return 0


sys.exit(main(sys.argv[1:]))

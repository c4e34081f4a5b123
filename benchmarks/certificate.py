"""What the certificate says of the reverse side, beside samples of the surface eight times finer than its own."""

import numpy as np

import subdfit
from benchmarks.common import MODELS, percent, table
from benchmarks.schemes import schemes
from subdfit.api.triangulate import triangles_of
from subdfit.limit import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure import reverse_segments
from subdfit.target.frame import Frame
from subdfit.target.target import Target, mesh_target

NAMES = ("fandisk", "block", "mechpart", "club", "casting", "goblet", "rocker-arm", "blade", "holes", "bunny")
BOUND = "0.2%"
FINER = 8
AT_ONCE = 500_000
"""Samples taken at once: of a whole surface there are too many."""


def run() -> str:
    """Fit models with every scheme, measure both ways, and return the table."""
    rows = [_row(name, scheme) for name in NAMES for scheme in schemes()]
    return table(["model", "scheme", "beyond the faceting, said %", "finer %", "reverse, said %", "finer %"], rows)


def _row(name: str, scheme: str) -> list[str]:
    result = subdfit.fit(MODELS / f"{name}.ply", max_error=BOUND, scheme=scheme, method="tangent")
    data = subdfit.read(MODELS / f"{name}.ply")
    target = mesh_target(data.points, triangles_of(data))
    frame = Frame.of(target.points[target.used])
    mesh = result.control_mesh
    surface = LimitSurface(mesh, scheme).with_points(frame.inside(mesh.points))
    excess, distance = _finer(surface, target.normalised(frame))
    said = result.measurement
    return [name, scheme, *(percent(v) for v in (said.reverse_excess, excess, said.reverse_max, distance))]


def _finer(surface: LimitSurface, target: Target) -> tuple[float, float]:
    """The largest excess and distance of fine samples of the surface."""
    segments = FINER * reverse_segments(surface.domain)
    cells = np.arange(surface.domain.face_count)
    most = np.full(2, -np.inf)
    for some in np.array_split(cells, max(1, len(cells) * segments**2 // AT_ONCE)):
        grid = lattice(surface.domain, segments, np.isin(cells, some))
        places = surface.evaluate(grid.face, grid.uv).position
        found = target.tree.closest(places)
        most = np.maximum(most, [(found.distance - target.allowance(places, found)).max(), found.distance.max()])
    return float(most[0]), float(most[1])

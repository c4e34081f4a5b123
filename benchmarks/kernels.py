"""Evaluations and footpoints a processor second, on a control mesh of 2,000 vertices of the bunny."""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.common import MODELS, table
from subdfit import parallel
from subdfit.closest.projection import Projector
from subdfit.initial import decimate
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend

POINTS = 1_000_000


def best(job: Callable[[], object], count: int) -> str:
    """Return millions a second of the fastest of five runs."""
    fastest = np.inf
    for _ in range(5):
        start = time.process_time()
        job()
        fastest = min(fastest, time.process_time() - start)
    return f"{count / fastest / 1e6:.1f}"


def run() -> str:
    """Measure on one thread and return the table."""
    parallel.set_threads(1)
    data = mend(read(MODELS / "bunny.ply")).data
    found = decimate(data.points, data.face_vertices.reshape(-1, 3), 2000)
    surface = LimitSurface(ControlMesh.from_triangles(found.points, found.triangles), "loop")
    t = surface.compiled.table
    whole = t.cell_node >= 0
    regular = whole & (t.type_levels[t.patch_type[np.where(whole, t.cell_node, 0)]] == 0)
    rng = np.random.default_rng(0)
    rows = []
    for name, cells in (("regular", np.flatnonzero(regular)), ("others", np.flatnonzero(~regular))):
        face = rng.choice(cells, POINTS).astype(np.int32)
        uv = rng.dirichlet([1, 1, 1], POINTS)[:, 1:].copy()
        for order, chosen in (("sorted by face", np.sort(face)), ("in random order", face)):
            speed = best(lambda c=chosen, w=uv: surface.evaluate(c, w, 1), POINTS)
            rows.append([f"position and first derivatives, {name} faces, {order}", speed])
    projector = Projector(surface)
    start = projector.start(data.points)
    settled = projector.refine(data.points, *start)
    count = len(data.points)
    rows.append(["warm footpoints", best(lambda: projector.refine(data.points, settled.face, settled.uv), count)])
    rows.append(["cold footpoints", best(lambda: projector.nearest(data.points), count)])
    parallel.set_threads(None)
    return table(["kernel, one core", "million a second"], rows)

"""Refinement of cages of 5,000 and 50,000 faces four times, and evaluations a second, for every scheme, on one core.

Seconds are the processor's, so that what else runs on the machine matters little: those of the program itself and,
after a plus sign, those in which the system finds memory for it. A virtual machine's system takes .1 to 3 s a GiB.
"""

import multiprocessing
import os
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from benchmarks.common import MODELS, peak, table
from subdfit import parallel
from subdfit.api import control_mesh_of, subdivide
from subdfit.initial import decimate
from subdfit.initial.pairing import pair_triangles
from subdfit.io import read
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES
from subdfit.schemes.domain import TRIANGLE

LEVELS = 4
POINTS = 1_000_000


def run() -> str:
    """Measure each row in a process of its own, whose peak of memory is then the row's, and return both tables."""
    refined, speeds = [], []
    for scheme in SCHEMES:
        for faces in (5_000, 50_000):
            refined.append(_apart(refinement, scheme, faces))
        speeds += _apart(evaluation, scheme)
    head = ["scheme", "faces", "refined four times", "s", "peak MiB", "at the limit, s", "peak MiB"]
    return table(head, refined) + "\n\n" + table(["scheme", "cells", "in order", "million a second"], speeds)


def _apart(job: Callable[..., Any], *arguments: object) -> Any:
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        return pool.submit(job, *arguments).result()


def cage(scheme: str, faces: int) -> ControlMesh:
    """Return Igea decimated to so many faces; where a scheme takes polygons, triangles joined in pairs."""
    triangles = SCHEMES[scheme].faces == "triangles"
    data = read(MODELS / "igea.ply")
    found = decimate(data.points, data.face_vertices.reshape(-1, 3), faces // 2 if triangles else faces)
    mesh = ControlMesh.from_triangles(found.points, found.triangles)
    return control_mesh_of(mesh if triangles else pair_triangles(mesh), scheme)


def refinement(scheme: str, faces: int) -> list[str]:
    """Return a row: seconds and peak of memory of refinement, then of refinement with limit points."""
    subdivide(cage(scheme, 200), 1, limit=True)
    mesh = cage(scheme, faces)
    row = [scheme, f"{mesh.topology.face_count:,}"]
    for limit in (False, True):
        start = os.times()
        fine = subdivide(mesh, LEVELS, limit=limit)
        stop = os.times()
        seconds = f"{stop.user - start.user:.1f} + {stop.system - start.system:.1f}"
        row += [seconds, peak()] if limit else [f"{fine.topology.face_count:,}", seconds, peak()]
        del fine
    return row


def evaluation(scheme: str) -> list[list[str]]:
    """Return rows: positions with first derivatives, in regular cells and in others, sorted by cell and not."""
    parallel.set_threads(1)
    surface = LimitSurface(cage(scheme, 5_000), scheme)
    patches, node = surface.compiled.table, surface.compiled.table.cell_node
    regular = (node >= 0) & (patches.type_levels[patches.patch_type[np.maximum(node, 0)]] == 0)
    random, rows = np.random.default_rng(0), []
    for name, cells in (("regular", np.flatnonzero(regular)), ("others", np.flatnonzero(~regular))):
        face, uv = random.choice(cells, POINTS).astype(np.int32), random.random((POINTS, 2))
        outside = (surface.domain.shape[face] == TRIANGLE) & (uv.sum(axis=1) > 1)
        uv[outside] = 1 - uv[outside]
        for order, chosen in (("of cells", np.argsort(face, kind="stable")), ("random", np.arange(POINTS))):
            rows.append([scheme, name, order, f"{POINTS / fastest(surface, face[chosen], uv[chosen]) / 1e6:.1f}"])
    return rows


def fastest(surface: LimitSurface, face: np.ndarray, uv: np.ndarray) -> float:
    """Return seconds of the fastest of five runs."""
    found = []
    for _ in range(5):
        start = time.process_time()
        surface.evaluate(face, uv, 1)
        found.append(time.process_time() - start)
    return min(found)

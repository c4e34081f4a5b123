"""Interpolation: the table of Cheng et al., rates on tori, fair surfaces, a million vertices against elimination."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse.linalg as spl

import subdfit
from benchmarks.common import MODELS, table
from subdfit.api.triangulate import triangles_of
from subdfit.api.workers import workers
from subdfit.errors import InputError
from subdfit.initial import decimate
from subdfit.initial.components import keep_components
from subdfit.interpolate import METHODS, Interpolation, LimitOperator, interpolate_points
from subdfit.interpolate.progressive import smallest_eigenvalue
from subdfit.io import read
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.repair import mend
from subdfit.schemes import SCHEMES, Scheme
from subdfit.target.frame import Frame

MILLION = 2**20
TABLE_1 = [("cube with a hole", 81_920, 7_666, 9), ("goblet", 129_280, 8_082, 7)]
TABLE_1 += [("rocker-arm", 203_904, 13_984, 5), ("beethoven", 262_016, 16_378, 5)]
"""Models of Cheng et al.: data points, vertices of the polyhedron, iterations that they print for an error of 1e-6."""
_PROGRAM = """
import sys, time
from pathlib import Path
from subdfit.cli import main
code = main(sys.argv[1:])
status = Path("/proc/self/status")
lines = status.read_text().splitlines() if status.exists() else ["VmHWM: nan"]
peak = next(line for line in lines if "VmHWM" in line).split()[1]
print(float(peak) / 2**20, time.process_time())
sys.exit(code)
"""
"""The command; then its peak memory in GiB (what getrusage tells would count the parent's) and its CPU seconds."""
TORI = {"doo-sabin": "49 / 28 / 14", "loop": "49 / 28 / 14", "catmull-clark": "118 / 62 / 21"}
"""Iterations that the eigenvalue bounds promise: plain, over-relaxed, conjugate gradients and Chebyshev."""

MEDIAN_OF = 7


class Seconds(NamedTuple):
    """By the clock, which other programs on the machine lengthen, and of all processors together."""

    wall: float
    cpu: float

    def __str__(self) -> str:
        return f"{self.wall:.2f} / {self.cpu:.2f}"


def run() -> str:
    """Measure all parts but the slow one and return their tables."""
    with workers(None):
        return "\n\n".join([printed_table(), tori(), fair()])


# The paper's table


def printed_table() -> str:
    """Iterations to 1e-6 of the diagonal, for the largest and for the mean error, with every Doo-Sabin mask."""
    rows = []
    for name, points, vertices, printed in TABLE_1:
        mesh = paper_model(name, points, vertices)
        for mask, scheme in masks().items():
            B, data = setting(scheme, mesh)
            plain = interpolate_points(B, mesh.topology, data, "progressive", 1e-6, 1000)
            fast = interpolate_points(B, mesh.topology, data, "cg", 1e-6, 1000)
            rows.append(
                [
                    name,
                    f"{points:,}",
                    f"{mesh.topology.vertex_count:,}",
                    mask,
                    str(printed),
                    str(len(plain.residuals) - 1),
                    str(mean_iterations(B, data)),
                    str(len(fast.residuals) - 1),
                ]
            )
    head = ["model", "points", "vertices", "mask", "printed", "plain, largest error", "plain, mean error", "cg"]
    return table(head, rows)


def masks() -> dict[str, Scheme]:
    """Schemes that are variants of Doo and Sabin's, by the name of their mask."""
    return {name: scheme for name, scheme in SCHEMES.items() if name.startswith("doo-sabin")}


def mean_iterations(B: LimitOperator, data: np.ndarray) -> int:
    """Plain iterations until the mean error is 1e-6 of the diagonal."""
    steps = METHODS["progressive"](B, data, data)
    return next(k for k, (points, _) in enumerate(steps) if B.distances(points, data).mean() <= 1e-6)


def paper_model(name: str, points: int, vertices: int) -> ControlMesh:
    """A model with the paper's counts: refined until it has more points, decimated to these, then to the vertices."""
    mesh = cube_with_hole() if name == "cube with a hole" else model(name)
    while mesh.topology.vertex_count < points:
        mesh = subdfit.subdivide(mesh, 1, "loop")
    for count in (points, vertices):
        found = decimate(mesh.points, mesh.topology.triangles, count)
        mesh = ControlMesh.from_triangles(found.points, found.triangles)
    return mesh


def model(name: str) -> ControlMesh:
    """The largest component of a model."""
    data = mend(read(MODELS / f"{name}.ply")).data
    kept = keep_components(data.points, triangles_of(data), 1)
    return ControlMesh.from_triangles(kept.points, kept.triangles)


def cube_with_hole() -> ControlMesh:
    """A cube with a square hole through it: a square ring of eight cubes, its outer faces cut into triangles."""
    cells = {(i, j, 0) for i in range(3) for j in range(3)} - {(1, 1, 0)}
    vertices: dict[tuple[int, ...], int] = {}
    triangles = []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                step = np.zeros(3, int)
                step[axis] = 2 * side - 1
                if tuple(np.array(cell) + step) in cells:
                    continue
                square = np.zeros((4, 3), int)
                square[:, axis] = side
                square[:, (axis + 1) % 3] = [0, 1, 1, 0]
                square[:, (axis + 2) % 3] = [0, 0, 1, 1]
                corners = [vertices.setdefault(tuple(p), len(vertices)) for p in (square + cell).tolist()]
                a, b, c, d = corners if side else corners[::-1]
                triangles += [[a, b, c], [a, c, d]]
    return ControlMesh.from_triangles(np.array(list(vertices), float) / [3, 3, 1], triangles)


# Rates


def tori() -> str:
    """Iterations by which the error on a regular torus has fallen to 1e-6 of the first."""
    rows = []
    for name, promised in TORI.items():
        if name not in SCHEMES:
            continue
        mesh = torus(60, 60, triangles=SCHEMES[name].faces == "triangles")
        noise = mesh.with_points(np.random.default_rng(0).standard_normal(mesh.points.shape))
        B, data = setting(SCHEMES[name], noise)
        first = float(B.distances(data, data).max())
        counts = {}
        for method in METHODS:
            found = interpolate_points(B, mesh.topology, data, method, 1e-6 * first, 1000)
            counts[method] = len(found.residuals) - 1
        low = smallest_eigenvalue(B)
        measured = " / ".join(str(counts[m]) for m in ("progressive", "over-relaxation", "cg", "chebyshev"))
        rows.append([name, f"{low:.4f}", promised, measured])
    head = [
        "torus of 60 x 60 random points",
        "smallest eigenvalue",
        "promised: plain / relaxed / cg",
        "measured / chebyshev",
    ]
    return table(head, rows)


def torus(rows: int, columns: int, *, triangles: bool) -> ControlMesh:
    """A regular torus of quads or triangles."""
    i, j = (x.ravel() for x in np.mgrid[:rows, :columns])
    a, b = i * columns + j, i * columns + (j + 1) % columns
    d, c = (i + 1) % rows * columns + j, (i + 1) % rows * columns + (j + 1) % columns
    s, t = 2 * np.pi * i / rows, 2 * np.pi * j / columns
    points = np.stack([(3 + np.cos(s)) * np.cos(t), (3 + np.cos(s)) * np.sin(t), np.sin(s)], axis=1)
    faces = np.vstack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]) if triangles else np.stack([a, b, c, d], 1)
    return subdfit.api.control_mesh_of((points, faces))


# Fair surfaces


def fair() -> str:
    """Thin-plate energy of plain and fair interpolation."""
    rows = []
    for name in ("beethoven", "bunny"):
        for scheme in SCHEMES.values():
            try:
                found = subdfit.interpolate(model(name), scheme=scheme.name, fair=True, creases="none")
            except InputError as error:
                rows.append([name, scheme.name, str(error), "", "", "", ""])
                continue
            assert found.energy is not None
            plain, least = found.energy
            rows.append(
                [
                    name,
                    scheme.name,
                    f"{plain:,.0f}",
                    f"{least:,.0f}",
                    f"{plain / least:.2f}",
                    f"{found.distances.max():.1e}",
                    f"{found.seconds['fair']:.1f}",
                ]
            )
    return table(["model", "scheme", "energy, plain", "fair", "quotient", "largest relative error", "s"], rows)


# A million vertices


def million() -> str:
    """Solve for a subdivided igea, against scipy's sparse elimination on the same matrix."""
    with workers(None):
        return million_table(list(SCHEMES.values()))


def million_table(schemes: list[Scheme]) -> str:
    """One row a scheme; the load is that of the whole machine, all programs together."""
    head = ["scheme", "vertices", "iterations", "relative error", "load", "limit rows", "solve", "splu", "quotient"]
    head += ["largest difference", "whole command", "its memory, GiB"]
    return "Seconds by the clock / of all processors.\n\n" + table(head, [million_row(scheme) for scheme in schemes])


def million_row(scheme: Scheme) -> list[str]:
    """Medians of several limit rows and solves; elimination and the whole command once."""
    mesh = large_igea(scheme)
    B, data = setting(scheme, mesh)
    made = timed(lambda: scheme.limit_rows(mesh.topology), MEDIAN_OF)[1]
    found, solved = timed(lambda: solve_afresh(B, mesh, data), MEDIAN_OF)
    load = os.getloadavg()[0]
    direct, elimination = timed(lambda: spl.splu(B.matrix.tocsc()).solve(data))
    whole, memory = command(scheme, mesh)
    return [
        scheme.name,
        f"{B.size:,}",
        str(len(found.residuals) - 1),
        f"{found.distances.max():.1e}",
        f"{load:.1f}",
        f"{made}",
        f"{solved}",
        f"{elimination}",
        f"{elimination.wall / solved.wall:.0f} / {elimination.cpu / solved.cpu:.0f}",
        f"{np.abs(direct - found.points).max():.0e}",
        f"{whole}",
        f"{memory:.2f}",
    ]


def solve_afresh(B: LimitOperator, mesh: ControlMesh, data: np.ndarray) -> Interpolation:
    """Solve without what the operator may have kept from a solution before."""
    return interpolate_points(LimitOperator(B.matrix), mesh.topology, data, "cg", 1e-10, 1000)


def large_igea(scheme: Scheme) -> ControlMesh:
    """Igea decimated so that two refinements by the scheme give about a million vertices."""
    igea = model("igea")
    growth = refined(scheme, decimated(igea, 2000)).topology.vertex_count / 2000
    return refined(scheme, decimated(igea, round(MILLION / growth)))


def decimated(mesh: ControlMesh, count: int) -> ControlMesh:
    """A mesh with fewer vertices."""
    found = decimate(mesh.points, mesh.topology.triangles, count)
    return ControlMesh.from_triangles(found.points, found.triangles)


def refined(scheme: Scheme, mesh: ControlMesh) -> ControlMesh:
    """Two refinements."""
    return subdfit.subdivide(mesh, 2, scheme.name)


def command(scheme: Scheme, mesh: ControlMesh) -> tuple[Seconds, float]:
    """Seconds and peak memory in GiB of the whole command, from file to file, in a fresh process."""
    with tempfile.TemporaryDirectory() as folder:
        source, out, document = (str(Path(folder) / name) for name in ("in.ply", "out.ply", "i.json"))
        subdfit.write(source, mesh)
        call = ["interpolate", source, "-o", out, "--scheme", scheme.name, "--tolerance", "1e-10", "--json", document]
        begun = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-c", _PROGRAM, *call, "--creases", "none", "--quiet"],
            check=True,
            capture_output=True,
            text=True,
        )
        wall = time.perf_counter() - begun
        memory, cpu = done.stdout.split()[-2:]
        assert json.loads(Path(document).read_text())["status"] == "within_tolerance"
    return Seconds(wall, float(cpu)), float(memory)


# Shared


def setting(scheme: Scheme, mesh: ControlMesh) -> tuple[LimitOperator, np.ndarray]:
    """Limit operator and normalised data."""
    scheme.validate(mesh.topology)
    return LimitOperator.of(scheme.limit_rows(mesh.topology)), Frame.of(mesh.points).inside(mesh.points)


def timed(job: Callable[[], Any], times: int = 1) -> tuple[Any, Seconds]:
    """What a job returns, and the medians of the seconds that it took each time."""
    taken = []
    for _ in range(times):
        begun, spent = time.perf_counter(), time.process_time()
        found = job()
        taken.append((time.perf_counter() - begun, time.process_time() - spent))
    return found, Seconds(*np.median(taken, axis=0).tolist())

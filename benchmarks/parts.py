"""Machined parts: curvature on bad triangles, and faces found by segmentation."""

import time
from dataclasses import replace

import numpy as np
from tests.shapes import grids, slivers
from tests.shapes.bad_meshes import decimated, noisy, with_slivers
from tests.shapes.chains import outline
from tests.shapes.paper_patches import boss, cushion, tube

import subdfit
from benchmarks.common import MODELS, table
from subdfit.curves.fitting import knots_removed
from subdfit.curves.loops import fit_loop
from subdfit.curves.polyline import Polyline
from subdfit.fit.lavoue_lightening import lightened
from subdfit.fit.lavoue_open import fit_open
from subdfit.fit.lavoue_optimisation import optimise
from subdfit.initial.lavoue import BoundaryPolygon, boundary_start
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.curvature import curvature_field
from subdfit.target.curves import boundary_loops
from subdfit.target.target import mesh_target

PARTS = ("fandisk", "fandisk_large", "block", "casting", "mechpart", "club")


def run() -> str:
    """Measure and return the tables."""
    steps = (curvature, segmentation, curves, starts, optimisation, open_surfaces, tessellations, whole_parts)
    return "\n\n".join(step() for step in steps)


def curvature() -> str:
    """Errors of direction and value on a cylinder and a torus of random vertices, joined as if stretched."""
    rows = []
    for shape in (slivers.cylinder, slivers.torus):
        for stretch in (0.3, 1.0, 3.0):
            for count in (3000, 12000):
                rows.append([shape.__name__, f"{stretch}", f"{count:,}", *_errors(shape(count, stretch))])
    head = [
        "surface",
        "stretch",
        "vertices",
        "aspect, p95",
        "direction, median",
        "p95",
        "largest curvature, median",
        "s",
    ]
    return table(head, rows)


def _errors(surface: slivers.Analytic) -> list[str]:
    clock = time.process_time()
    found = curvature_field(surface.points, surface.triangles).at_vertices()
    clock = time.process_time() - clock
    cosine = np.abs(np.sum(found.minimum_direction * surface.minimum_direction, axis=1))
    off = np.degrees(np.arccos(np.clip(cosine, 0, 1)))
    wrong = np.median(np.abs(found.maximum / surface.maximum - 1))
    values = [f"{np.median(off):.2f}°", f"{np.percentile(off, 95):.2f}°", f"{100 * wrong:.1f} %", f"{clock:.2f}"]
    return [f"{_aspect(surface.points[surface.triangles]):.0f}", *values]


def _aspect(corners: np.ndarray) -> float:
    """95th percentile of the longest side over the height on it."""
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return float(np.percentile(sides**2 / area, 95))


def curves() -> str:
    """Control points of closed curves at .5 % of the diagonal, beside greedy knot removal where there is no corner."""
    shape = outline()
    loops = [("as in Figure 3", shape, float(np.linalg.norm(np.ptp(shape.points, axis=0))))]
    for name in ("cylinder", "holes", "mech-holes-shark", "blade"):
        data = subdfit.read(MODELS / f"{name}.ply")
        diagonal = float(np.linalg.norm(np.ptp(data.points, axis=0)))
        for loop in boundary_loops(data.face_vertices.reshape(-1, 3)):
            loops.append((name, Polyline(data.points[loop.vertices], closed=True), diagonal))
    rows = []
    for name, target, diagonal in loops:
        clock = time.process_time()
        found = fit_loop(target, 5e-3 * diagonal)
        clock = time.process_time() - clock
        removal = "-"
        if not found.corners.any():
            left = knots_removed(target, 5e-3 * diagonal, begin=len(found.points) + 5)
            removal = str(len(left.curve.points))
        counts = [str(len(target.points)), str(found.corners.sum()), str(len(found.points)), removal]
        rows.append([name, *counts, f"{100 * found.error / diagonal:.3f}", f"{clock:.2f}"])
    head = ["mesh", "loop's points", "sharp", "control points", "by knot removal", "largest error %", "CPU s"]
    return table(head, rows)


def starts() -> str:
    """Control meshes of open surfaces from their boundary curves at .5 % of the diagonal."""
    rows = []
    for name in ("cylinder", "blade", "holes", "mech-holes-shark", "plane_holes"):
        data = subdfit.read(MODELS / f"{name}.ply")
        triangles = data.face_vertices.reshape(-1, 3)
        diagonal = float(np.linalg.norm(np.ptp(data.points, axis=0)))
        loops = boundary_loops(triangles)
        fits = [fit_loop(Polyline(data.points[loop.vertices], closed=True), 5e-3 * diagonal) for loop in loops]
        polygons = [BoundaryPolygon(fit.points, fit.corners, fit.limits) for fit in fits]
        for paths in ("geodesic", "dijkstra"):
            clock = time.process_time()
            topology = boundary_start(data.points, triangles, polygons, paths=paths).topology
            clock = time.process_time() - clock
            quads = int(np.sum(np.diff(topology.face_offsets) == 4))
            counts = [str(topology.vertex_count), str(topology.face_count), str(quads)]
            rows.append([name, str(len(loops)), paths, *counts, f"{clock:.1f}"])
    return table(["surface", "boundaries", "paths", "control vertices", "faces", "quads", "CPU s"], rows)


def optimisation() -> str:
    """As in the paper's Figure 9: mean error from bad starts, in thousandths of the unit cube's side."""
    rows = [["the paper", metric, "-", *after] for metric, *after in PAPER]
    for scheme, whole in (("quad-triangle", 10), ("catmull-clark", 25)):
        mesh = _wavy(scheme, whole)
        fine = subdfit.LimitSurface(mesh).tessellate(4)
        target = mesh_target(fine.points, fine.triangles, creases="none")
        field = curvature_field(target.points, target.triangles, 0.1)
        rim = mesh.topology.boundary_vertices
        for size in (0.15, 0.47, 0.98):
            bad = mesh.points.copy()
            bad[~rim] += size * np.random.default_rng(3).uniform(-1, 1, (16, 3)) * [1, 1, 0.6]
            for metric, *_ in PAPER:
                found = optimise(mesh.with_points(bad), target, field, fixed=rim, metric=metric)
                rows.append([scheme, metric, *(f"{1000 * found.mean[k]:.2f}" for k in (0, 1, 5))])
    return table(["control mesh", "metric", "start", "after 1 iteration", "after 5"], rows)


PAPER = (("squared-distance", "15.9", "5.0"), ("point", "21.4", "16.1"))


def _wavy(scheme: str, whole: int) -> ControlMesh:
    """A wavy square of 25 quads, of which so many are left whole and the others cut in two triangles."""
    x, y = np.meshgrid(np.arange(6), np.arange(6), indexing="ij")
    points = np.stack([x, y, 0.8 * np.sin(x) * np.cos(0.7 * y)], -1).reshape(-1, 3) / 5
    quads = grids.quads_of(grids.vertices(6, 6))
    faces = [*quads[:whole], *grids.cut(quads[whole:])]
    offsets = np.cumsum([0, *map(len, faces)])
    return ControlMesh(Topology.from_faces(offsets, np.concatenate(faces), 36), points, scheme)


OPEN = (
    (cushion, "the paper's Figure 12a", "20/30", "2.69"),
    (boss, "the paper's Figure 12b", "16/17", "2.06"),
    (tube, "the paper's cylinder, 12c", "10/5", "1.72"),
)
"""Surfaces with the counts of those of the paper's Table 1, and its results."""


def open_surfaces() -> str:
    """The nested loop, and without what it did not need; boundary curves at .5 % of the longest side, holes at 2 %."""
    rows = []
    for make, title, counts, error in OPEN:
        rows.append([title, "quad-triangle", "5", "-", counts, "-", error, "-", "-", "-"])
        # The rims of the tube are held, and are farther off than the paper's mean error.
        for asked in (5.0,) if make is tube else (5.0, float(error)):
            rows += _nested(make.__name__, make(), 5e-3, asked)
    for name in ("cylinder", "blade", "holes"):
        data = subdfit.read(MODELS / f"{name}.ply")
        share = 2e-2 if name == "holes" else 5e-3
        rows += _nested(name, (data.points, data.face_vertices.reshape(-1, 3)), share, 5.0)
    head = ["surface", "scheme", "asked, 1e-3 of the side", "start V/F", "nested loop V/F", "lightened V/F"]
    return table([*head, "mean error, 1e-3 of the side", "largest %", "optimisations", "CPU s"], rows)


def _nested(name: str, mesh: tuple[np.ndarray, np.ndarray], share: float, asked: float) -> list[list[str]]:
    """Rows of one surface by both schemes."""
    points, triangles = mesh
    side, rows = float(np.ptp(points, axis=0).max()), []
    begin = open_start(points, triangles, share * side)
    for scheme in ("quad-triangle", "catmull-clark"):
        start = replace(begin, scheme=scheme)
        target, clock = mesh_target(points, triangles), time.process_time()
        field, tolerance = curvature_field(points, triangles), 1e-3 * asked * side
        nested = fit_open(start, target, field, tolerance=tolerance)
        found = lightened(nested, target, field, tolerance)
        clock = time.process_time() - clock
        meshes = (start, nested.mesh, found.mesh)
        counts = [f"{m.topology.vertex_count}/{m.topology.face_count}" for m in meshes]
        error = f"{1000 * found.mean / side:.2f}" + ("" if found.within else ", not within")
        measured = subdfit.measure(found.mesh, mesh)
        far = f"{100 * max(measured.max, measured.reverse_max):.2f}"
        rows.append([name, scheme, f"{asked:g}", *counts, error, far, str(len(found.history)), f"{clock:.1f}"])
    return rows


def open_start(points: np.ndarray, triangles: np.ndarray, tolerance: float) -> ControlMesh:
    """Control mesh of an open surface from its boundary curves within a tolerance."""
    fits = [fit_loop(Polyline(points[loop.vertices], closed=True), tolerance) for loop in boundary_loops(triangles)]
    return boundary_start(points, triangles, [BoundaryPolygon(fit.points, fit.corners, fit.limits) for fit in fits])


def tessellations() -> str:
    """As in the paper's Figures 1 and 12c: a cylinder well and badly meshed, judged on the mesh as given."""
    data = subdfit.read(MODELS / "cylinder.ply")
    well = data.points, data.face_vertices.reshape(-1, 3)
    meshes = {
        "as given": well,
        "with slivers": with_slivers(*well),
        "decimated": decimated(*well),
        "noise of 0.1 %": noisy(*well),
    }
    rows = []
    for asked in ("1%", "0.3%"):
        for name, mesh in meshes.items():
            clock = time.process_time()
            found = subdfit.fit(mesh, scheme="quad-triangle", method="lavoue", max_error=asked)
            clock = time.process_time() - clock
            topology, errors = found.control_mesh.topology, subdfit.measure(found.control_mesh, well)
            counts = [f"{len(mesh[0]):,}/{len(mesh[1]):,}", f"{topology.vertex_count}/{topology.face_count}"]
            shares = [f"{100 * error:.3f}" for error in (errors.rms, errors.max)]
            aspect = f"{_aspect(mesh[0][mesh[1]]):.0f}"
            rows.append([asked, name, counts[0], aspect, counts[1], *shares, "yes" if found.certified else "no"])
            rows[-1].append(f"{clock:.1f}")
    head = ["asked", "mesh", "its V/F", "aspect, p95", "V/F", "rms %", "largest %", "certified", "CPU s"]
    return table(head, rows)


ALL = ("lavoue", "tangent", "thin")
WHOLE = (
    ("fandisk", ALL, {"mean_error": "0.0537%"}),
    ("fandisk", ("lavoue", "thin"), {"max_error": "1%"}),
    ("block", ("lavoue", "tangent"), {"max_error": "1%"}),
    ("mechpart", ("lavoue", "thin"), {"max_error": "1%"}),
    ("blade", ("lavoue", "thin"), {"max_error": "1%"}),
    ("casting", ("lavoue",), {"max_error": "1%"}),
    ("fandisk", ALL, {"max_error": "0.3%"}),
    ("block", ALL, {"max_error": "0.3%"}),
    ("mechpart", ALL, {"max_error": "0.3%"}),
    ("casting", ("lavoue", "tangent"), {"max_error": "0.3%"}),
    ("club", ALL, {"max_error": "0.3%"}),
    ("rocker-arm", ALL, {"max_error": "0.3%"}),
    ("mechpart", ("lavoue", "thin"), {"max_error": "0.458%", "rms_error": "0.0572%"}),
    ("fandisk", ("lavoue", "tangent"), {"max_error": "0.1%"}),
)


def whole_parts() -> str:
    """Whole parts, also by `tangent`, with `--thin` too; .0537 % of fandisk's diagonal is .78e-3 of the cube's side."""
    rows = [
        ["fandisk", "the paper", "mean 0.0537%", "75/89", "0.78", "1.20", "-", "-", "-", "-", "5"],
        ["fandisk", "Hoppe et al.", "-", "87/170", "-", "0.25", "-", "-", "-", "-", "-"],
        ["mechpart", "Subdivfit", "-", "141/-", "-", "-", "0.0572", "0.46", "-", "-", "60"],
    ]
    for name, methods, asked in WHOLE:
        for method in methods:
            thin = method == "thin"
            how = {"method": "tangent" if thin else method, "scheme": "quad-triangle", **asked}
            clock = time.process_time()
            found = subdfit.fit(MODELS / f"{name}.ply", thin=thin, **how)
            clock = time.process_time() - clock
            rows.append([name, method, ", ".join(f"{k[:-6]} {v}" for k, v in asked.items()), *_whole(name, found)])
            rows[-1].append(f"{clock:.1f}")
    head = ["part", "method", "asked", "V/F", "mean, 1e-3 of the side", "mean square, 1e-5", "rms %", "largest %"]
    return table([*head, "reverse %", "certified", "CPU s"], rows)


def _whole(name: str, found: subdfit.FitResult) -> list[str]:
    m, topology = found.measurement, found.control_mesh.topology
    side = float(np.ptp(subdfit.read(MODELS / f"{name}.ply").points, axis=0).max()) / m.diagonal
    errors = [f"{1000 * m.mean / side:.2f}", f"{1e5 * (m.rms / side) ** 2:.2f}"]
    errors += [
        f"{100 * m.rms:.4f}",
        f"{100 * m.max:.2f}",
        f"{100 * m.reverse_max:.2f}",
        "yes" if found.certified else "no",
    ]
    return [f"{topology.vertex_count}/{topology.face_count}", *errors]


def segmentation() -> str:
    """Faces and feature edges of parts."""
    rows = []
    for name in PARTS:
        clock = time.process_time()
        found = subdfit.segment(MODELS / f"{name}.ply")
        clock = time.process_time() - clock
        counts = [f"{len(found.triangles):,}", str(found.count), f"{len(found.feature_edges):,}"]
        rows.append([name, *counts, f"{clock:.1f}"])
    return table(["part", "triangles", "faces", "feature edges", "CPU s"], rows)

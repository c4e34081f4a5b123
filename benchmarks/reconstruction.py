"""Reconstruction from points: stages, shape, agreement with the original mesh and with CGAL; fits to clouds."""

import time
from importlib.util import find_spec

import numpy as np
from scipy.spatial import cKDTree

import subdfit
from benchmarks.common import MODELS, percent, table
from subdfit.api.workers import workers
from subdfit.initial.delaunay import small_facets, spacing
from subdfit.initial.distinct import distinct
from subdfit.initial.reconstruct import GAP, reconstruct
from subdfit.initial.simplify import simplify
from subdfit.mesh.data import MeshData
from subdfit.mesh.topology import Topology
from subdfit.target.frame import Frame

MESHES = ("kitten_points", "bunny", "armadillo_50k", "igea")
AGREEMENT = ("kitten_points", "bunny", "igea", "distcap_points", "fandisk", "cactus_points")
"""Clouds compared with CGAL's triangles. The time that its package takes grows with the square of the number of points:
igea's take twelve minutes."""

CLOUDS = {
    "kitten_points": {"max_error": "0.1%"},
    "distcap_points": {"max_error": "0.2%"},
    "cactus_points": {"max_error": "0.2%"},
    "rangemap_lato315_points": {"max_error": "0.1%"},
    "mechpart_points_synthetic_noisy": {"rms_error": "0.25%"},
}


def run() -> str:
    """Print the tables."""
    return "\n\n".join([_speed(), _agreement(), _simplification(), _fits()])


def _points(name: str) -> tuple[np.ndarray, np.ndarray | None, MeshData]:
    """The points that are used, and the original triangles where there are some."""
    data = subdfit.read(MODELS / f"{name}.ply")
    if not data.face_count:
        return data.points, None, data
    used, rows = np.unique(data.face_vertices, return_inverse=True)
    return data.points[used], rows.reshape(-1, 3), data


def _speed() -> str:
    reconstruct(_points("cactus_points")[0])  # compile first
    rows = []
    for name in MESHES:
        points, _, _ = _points(name)
        inside = Frame.of(points).inside(points[distinct(points)])
        begun = time.process_time()
        small_facets(inside, GAP * spacing(inside))
        delaunay = time.process_time() - begun
        begun, clock = time.process_time(), time.perf_counter()
        with workers(None):
            found = reconstruct(points)
        whole, seconds = time.process_time() - begun, time.perf_counter() - clock
        t = Topology.from_triangles(found.triangles, len(found.points))
        euler = t.vertex_count - t.edge_count + t.face_count
        rows.append([name, f"{len(points):,}", f"{t.face_count:,}", str(len(found.left_out)), str(euler),
                     str(np.count_nonzero(t.boundary_edges)), f"{delaunay:.2f}", f"{whole:.2f}",
                     f"{seconds:.2f}"])  # fmt: skip
    head = [
        "points",
        "number",
        "triangles",
        "left out",
        "Euler number",
        "boundary edges",
        "CPU s Delaunay",
        "CPU s all",
        "s all",
    ]
    return table(head, rows)


def _agreement() -> str:
    rows = []
    for name in AGREEMENT:
        points, original, _ = _points(name)
        ours = _sets(reconstruct(points, gap=np.inf, small_hole=0))
        own = None if original is None else _rows(original)
        cells = ["-"] * 6
        if find_spec("CGAL"):
            begun = time.process_time()
            theirs = _sets(reconstruct(points, engine="cgal", small_hole=0))
            seconds = time.process_time() - begun
            sure = [_without_ties(points, found) for found in (ours, theirs)]
            cells = [_shared(ours, theirs), f"{len(sure[0]):,}", str(len(sure[1] - sure[0]))]
            cells += [str(len(sure[0] - sure[1])), _shared(*sure), f"{seconds:.1f}"]
        rows.append([name, f"{len(ours):,}", *cells, _shared(ours, own)])
    head = ["points", "triangles", "shared with CGAL", "without ties", "only CGAL's", "only ours", "shared of these"]
    return table([*head, "CPU s CGAL", "shared with the original mesh"], rows)


def _without_ties(points: np.ndarray, triangles: set[tuple[int, ...]]) -> set[tuple[int, ...]]:
    """The triangles on whose circumscribing sphere no fourth point lies, to the precision of float32 files.

    Only these are determined by the points: of four points on a circle either diagonal is as good.
    """
    rows = np.array(sorted(triangles))
    a, b, c = (points[rows[:, k]] for k in range(3))
    u, v = b - a, c - a
    normal = np.cross(u, v)
    squares = [np.sum(x * x, axis=1, keepdims=True) for x in (u, v, normal)]
    centre = a + np.cross(squares[0] * v - squares[1] * u, normal) / (2 * squares[2])
    distance, _ = cKDTree(np.unique(points, axis=0)).query(centre, 8)
    near = 4 * np.finfo(np.float32).eps * Frame.of(points).diagonal
    on = np.abs(distance - np.linalg.norm(centre - a, axis=1, keepdims=True)) <= near
    return set(map(tuple, rows[on.sum(axis=1) <= 3].tolist()))


def _rows(triangles: np.ndarray) -> set[tuple[int, ...]]:
    return set(map(tuple, np.sort(triangles, axis=1).tolist()))


def _sets(found) -> set[tuple[int, ...]]:  # type: ignore[no-untyped-def]
    return _rows(found.point_rows[found.triangles])


def _shared(ours: set[tuple[int, ...]], others: set[tuple[int, ...]] | None) -> str:
    return "-" if others is None else f"{100 * len(ours & others) / max(len(ours), len(others)):.2f} %"


def _simplification() -> str:
    rows = []
    points, _, _ = _points("igea")
    found = reconstruct(points)
    diagonal = Frame.of(points).diagonal
    for asked in ({"vertices": 7666}, {"max_error": 1e-3 * diagonal}, {"max_error": 1e-4 * diagonal}):
        for keep in (True, False):
            begun = time.process_time()
            simple = simplify(found.points, found.triangles, keep_points=keep, **asked)
            what = " ".join(f"{k} {v if k == 'vertices' else percent(v / diagonal) + ' %'}" for k, v in asked.items())
            rows.append([f"igea, {what}", "data points" if keep else "best points", f"{len(simple.points):,}",
                         percent(simple.error / diagonal), f"{time.process_time() - begun:.1f}"])  # fmt: skip
    return table(["simplified to", "vertices are", "vertices", "largest error, %", "CPU s"], rows)


def _fits() -> str:
    rows = []
    for name, asked in CLOUDS.items():
        begun = time.process_time()
        result = subdfit.fit(MODELS / f"{name}.ply", **asked)
        m = result.measurement
        rows.append([name, " ".join(f"{k} {v}" for k, v in asked.items()), f"{len(m.footpoints.distance):,}",
                     f"{result.control_mesh.topology.vertex_count:,}", percent(m.max), percent(m.rms),
                     str(len(m.excluded)), "yes" if result.certified else "no",
                     f"{time.process_time() - begun:.1f}"])  # fmt: skip
    head = ["cloud", "asked", "points", "control vertices", "E_max, %", "E_rms, %", "left out", "certified", "CPU s"]
    return table(head, rows)

"""`subdfit.reconstruct`: from unorganised points to a triangle mesh."""

import logging
import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subdfit.api.components import largest_of_cloud
from subdfit.api.fitting import elapsed
from subdfit.api.lengths import Length, parse_bytes, parse_length, share_of
from subdfit.api.memory import check_job
from subdfit.api.sources import MeshSource, source_of
from subdfit.api.targets import check_count, stages
from subdfit.api.workers import workers
from subdfit.compiled import compile_clock
from subdfit.errors import InputError
from subdfit.initial.cloud_checks import tell
from subdfit.initial.distinct import distinct
from subdfit.initial.holes import fill_holes
from subdfit.initial.poisson import poisson_mesh
from subdfit.initial.reconstruct import ENGINES, GAP, SMALL_HOLE, Reconstructed
from subdfit.initial.reconstruct import reconstruct as join_points
from subdfit.initial.simplify import LEAST_VERTICES, Simplified, simplify
from subdfit.mesh.data import MeshData
from subdfit.mesh.repair import check
from subdfit.target.bvh import TriangleTree
from subdfit.target.frame import Frame
from subdfit.wording import counted

logger = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]

METHODS = (*ENGINES, "poisson")


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """A triangle mesh made from a cloud of points.

    Attributes
    ----------
    mesh : the triangles, an oriented manifold; its points are in the cloud's unit.
    cloud : (n, 3) float64, the points given.
    point_rows : (k,) int64, the row in the cloud of each point of the mesh; None where vertices are no data points.
    left_out : (l,) int64, rows of the cloud that the surface does not pass through though it was to, repeats of points
        that it does pass through not counted.
    repeated : number of points that repeat another's position.
    error : largest distance from the mesh of the points not left out, in the cloud's unit.
    settings : what was asked.
    seconds : ``total``, and ``compile``, which is not in it.
    """

    mesh: MeshData
    cloud: NDArray[np.float64]
    point_rows: Rows | None
    left_out: Rows
    repeated: int
    error: float
    settings: dict[str, Any]
    seconds: dict[str, float]

    def to_dict(self) -> dict[str, Any]:
        """What ``--json`` writes."""
        return {
            "method": self.settings["method"],
            "vertices": len(self.mesh.points),
            "faces": self.mesh.face_count,
            "error": self.error,
            "left_out": self.left_out.tolist(),
            "repeated": self.repeated,
            "settings": self.settings,
            "seconds": self.seconds,
        }


def reconstruct(
    points: MeshSource,
    *,
    method: str = "greedy",
    gap: float = GAP,
    small_hole: int = SMALL_HOLE,
    keep_components: int | None = None,
    vertices: int | None = None,
    max_error: float | str | None = None,
    keep_data_points: bool = False,
    threads: int | None = None,
    memory: int | str | None = None,
) -> Reconstruction:
    """Join unorganised points to a triangle mesh.

    Parameters
    ----------
    points
        An array of points, a path, or anything else that `subdfit.fit` takes; faces, if there are any, are not looked
        at. Normals in the file decide which side is outside; without them closed surfaces are turned outward.
    method
        ``greedy`` passes through the points (Cohen-Steiner and Da 2004); ``cgal`` is the same by the CGAL library, an
        extra; ``poisson`` passes near noisy points, by Open3D, an extra.
    gap
        Voids wider than so many times the distance between neighbouring points are holes.
    small_hole
        Holes of at most so many edges are closed.
    keep_components
        Keep so many of the largest components; the points of the others are left out.
    vertices
        Simplify to so many vertices, topology kept.
    max_error
        Simplify to the fewest vertices, but no fewer than `vertices`, of which all points joined lie within this: a
        length in the points' unit, or a share of the diagonal such as ``"0.01%"``.
    keep_data_points
        Simplify to some of the points, instead of to vertices of least error; with `vertices` or `max_error`.
    threads
        Threads to use; None takes one a core. The result does not depend on it.
    memory
        Bytes, or a string such as ``"2G"``: refuse at once what would need more.

    Returns
    -------
    Reconstruction

    Raises
    ------
    InputError
        The points cannot be read, there are too few, or no clean surface passes through them; a library is missing.

    Examples
    --------
    >>> found = subdfit.reconstruct("scan.xyz", max_error="0.01%")  # doctest: +SKIP
    >>> subdfit.write("scan.ply", found.mesh)  # doctest: +SKIP
    """
    asked = _Asked(method, gap, small_hole, keep_components, vertices, max_error, keep_data_points)
    length, limit = parse_length(max_error, "max_error"), parse_bytes(memory)
    begun, compiled = time.perf_counter(), compile_clock.seconds
    with workers(threads):
        stages.info("reading")
        data, name = source_of(points)
        check(data, name)
        check_job(len(data.points), 0, limit, name)
        stages.info("joining points")
        found = largest_of_cloud(_joined(data, asked, name), keep_components, name)
        simple, rows = _simplified(found, asked, length)
        error = simple.error if len(found.point_rows) else _largest_error(data.points, found.left_out, simple)
    return Reconstruction(
        mesh=MeshData(simple.points, 3 * np.arange(len(simple.triangles) + 1), simple.triangles.ravel()),
        cloud=data.points,
        point_rows=rows,
        left_out=found.left_out,
        repeated=found.repeated,
        error=error,
        settings=asdict(asked) | {"threads": threads, "memory": limit},
        seconds=elapsed(begun, compiled),
    )


@dataclass(frozen=True)
class _Asked:
    """What decides the mesh; the fields are arguments of `reconstruct`."""

    method: str
    gap: float
    small_hole: int
    keep_components: int | None
    vertices: int | None
    max_error: float | str | None
    keep_data_points: bool

    def __post_init__(self) -> None:
        """Raise InputError for options that cannot be, before any work is done."""
        if self.method not in METHODS:
            raise InputError(f"unknown method '{self.method}'; choose one of {', '.join(METHODS)}")
        if not self.gap > 0:
            raise InputError(f"gap is {self.gap}; give a number above 0")
        if self.method == "poisson" and self.keep_data_points:
            raise InputError("the Poisson surface passes near the points, not through them; leave keep_data_points out")
        if self.keep_data_points and self.vertices is None and self.max_error is None:
            raise InputError("keep_data_points says to what a mesh is simplified; give vertices or max_error, too")
        for name, least in (("small_hole", 0), ("keep_components", 1), ("vertices", LEAST_VERTICES)):
            check_count(getattr(self, name), name, least)


def _joined(data: MeshData, asked: _Asked, name: str) -> Reconstructed:
    if asked.method != "poisson":
        return join_points(
            data.points, data.normals, gap=asked.gap, small_hole=asked.small_hole, engine=asked.method, name=name
        )
    smooth = poisson_mesh(data.points, data.normals, gap=asked.gap, name=name)
    closed = fill_holes(smooth.points, smooth.triangles, asked.small_hole)
    far = np.flatnonzero(_distances(data.points, closed.points, closed.triangles) > smooth.reach)
    tell(len(far), 0, len(data.points), name)
    repeated = len(data.points) - len(distinct(data.points))
    return Reconstructed(closed.points, closed.triangles, np.empty(0, np.int64), far, repeated)


def _distances(cloud: Floats, points: Floats, triangles: Rows) -> Floats:
    """Distance of each point of a cloud from a mesh, (n,)."""
    return TriangleTree(points, triangles).closest(cloud).distance


def _largest_error(cloud: Floats, left_out: Rows, mesh: Simplified) -> float:
    """Largest distance from the mesh of the points that are not left out."""
    return float(_distances(np.delete(cloud, left_out, axis=0), mesh.points, mesh.triangles).max(initial=0.0))


def _simplified(found: Reconstructed, asked: _Asked, length: Length | None) -> tuple[Simplified, Rows | None]:
    """The mesh with fewer vertices, if that was asked for, and the cloud's rows of its vertices."""
    known = found.point_rows if len(found.point_rows) else None
    if asked.vertices is None and length is None:
        return Simplified(found.points, found.triangles, known, 0.0), known
    stages.info("simplifying")
    diagonal = Frame.of(found.points).diagonal
    share = share_of(length, "max_error", diagonal)
    simple = simplify(
        found.points,
        found.triangles,
        vertices=asked.vertices,
        max_error=share and share * diagonal,
        keep_points=asked.keep_data_points,
    )
    _tell_count(len(found.points), asked, simple)
    return simple, None if known is None or simple.point_rows is None else known[simple.point_rows]


def _tell_count(joined: int, asked: _Asked, simple: Simplified) -> None:
    """Say where the count that was asked for is out of reach."""
    if asked.vertices is not None and asked.vertices > joined:
        there, wanted = counted(joined, "vertex"), f"{asked.vertices:,}"
        logger.warning("the mesh through the points has %s, %s were asked for: not simplified", there, wanted)
    elif asked.max_error is None and simple.message:
        logger.warning("%s", simple.message)

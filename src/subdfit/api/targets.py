"""From whatever the caller has to a target that can be fitted: read, mended, cut down, closed, its creases known."""

import logging
import math
import os
import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from subdfit.api.components import largest_of_cloud
from subdfit.api.memory import check_file, check_job
from subdfit.api.sources import MeshSource, source_of
from subdfit.api.triangulate import triangles_of
from subdfit.errors import InputError
from subdfit.initial.components import keep_components
from subdfit.initial.holes import fill_holes
from subdfit.initial.reconstruct import Reconstructed, reconstruct
from subdfit.mesh.data import MeshData
from subdfit.mesh.repair import mend
from subdfit.target.curves import boundary_corners
from subdfit.target.target import Creases, Target, cloud_target, mesh_target, point_target
from subdfit.wording import counted

logger = logging.getLogger(__name__)
stages = logging.getLogger("subdfit.api.stages")


@dataclass(frozen=True)
class Preparation:
    """How a target is made ready; the attributes are the arguments of `subdfit.fit`.

    Attributes
    ----------
    creases : ``auto`` takes the creases that the file tags, else edges that are surely sharp; ``none``; or degrees.
    repair, keep_components, fill_holes : what may be changed; None leaves all components and holes. A cloud's
        components and holes are those of the surface through its points.
    memory : bytes, or None.
    """

    creases: Creases = "auto"
    repair: bool = False
    keep_components: int | None = None
    fill_holes: int | None = None
    memory: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "creases", _creases(self.creases))
        for name, least in (("keep_components", 1), ("fill_holes", 3)):
            check_count(getattr(self, name), name, least)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A target made ready.

    Attributes
    ----------
    target : in the caller's unit.
    name : what messages call it.
    seconds : by stage, compiling included.
    """

    target: Target
    name: str
    seconds: dict[str, float] = field(default_factory=dict)


def check_count(given: int | None, name: str, least: int) -> None:
    """Raise InputError unless an option is None or a whole number from `least` on."""
    if given is not None and (isinstance(given, bool) or not isinstance(given, int | np.integer) or given < least):
        raise InputError(f"{name} is {given!r}; give a whole number, {least} or more")


def prepare(given: MeshSource, how: Preparation) -> Prepared:
    """Make a target ready for fitting or measuring.

    Raises
    ------
    InputError
        The data cannot be read, mended or used, or the work would need more memory than allowed.
    """
    clock = time.perf_counter()
    stages.info("reading")
    if isinstance(given, str | os.PathLike):
        check_file(given, how.memory)
    data, name = source_of(given)
    read = time.perf_counter() - clock
    check_job(len(data.points), len(data.face_vertices), how.memory, name)
    clock = time.perf_counter()
    stages.info("mending")
    mended = mend(data, repair=how.repair, name=name).data
    _require_extent(mended.points, name)
    target = _mesh(mended, how, name) if mended.face_count else point_target(mended.points, mended.normals)
    return Prepared(target, name, {"read": read, "prepare": time.perf_counter() - clock})


def joined(ready: Prepared, how: Preparation) -> Prepared:
    """A cloud with the triangles that guide a fit to it, cut down and closed as asked; meshes as they are.

    Raises
    ------
    InputError
        No clean surface passes through the points.
    """
    if ready.target.is_mesh:
        return ready
    clock = time.perf_counter()
    stages.info("joining points")
    points, normals = ready.target.points, ready.target.normals
    found = reconstruct(points, normals if normals.any() else None, name=ready.name)
    kept = largest_of_cloud(found, how.keep_components, ready.name)
    used = _near(points, found, kept)
    guide, triangles = _closed(kept.points, kept.triangles, how, ready.name)
    added = guide[len(kept.points) :]
    rows = np.concatenate([kept.point_rows, len(points) + np.arange(len(added))])
    sharp: Creases = "none" if how.creases == "auto" else how.creases
    target = cloud_target(np.concatenate([points, added]), rows[triangles], creases=sharp, used=used)
    return Prepared(target, ready.name, ready.seconds | {"reconstruct": time.perf_counter() - clock})


def _require_extent(points: NDArray[np.float64], name: str) -> None:
    """Raise InputError where there is nothing to fit."""
    extent = np.ptp(points, axis=0)
    if not extent.any():
        raise InputError(f"{name}: all points coincide, there is nothing to fit; export it again")
    if not np.linalg.norm(extent) > 0:  # its square is less than the least number
        raise InputError(f"{name}: all points lie within {extent.max():.2g} of each other; scale them up")


def _near(points: NDArray[np.float64], found: Reconstructed, kept: Reconstructed) -> NDArray[np.int64]:
    """Rows of the points, noise too, that lie nearer to what is kept of the surface than to the rest."""
    if len(kept.points) == len(found.points):
        return np.arange(len(points))
    _, nearest = cKDTree(found.points).query(points)
    return np.flatnonzero(np.isin(found.point_rows[nearest], kept.point_rows))


def _mesh(data: MeshData, how: Preparation, name: str) -> Target:
    points, triangles = data.points, triangles_of(data)
    rows = np.arange(len(points))
    if how.keep_components is not None:
        kept = keep_components(points, triangles, how.keep_components)
        rows = kept.point_rows
        points, triangles = kept.points, kept.triangles
        stays = min(how.keep_components, kept.component_count)
        logger.info("%s: kept %d of %s", name, stays, counted(kept.component_count, "component"))
    points, triangles = _closed(points, triangles, how, name)
    tagged = _tagged_creases(data, rows) if how.creases == "auto" else np.empty((0, 2), np.int64)
    target = mesh_target(points, triangles, creases="none" if len(tagged) else how.creases)
    if not len(tagged):
        return target
    return replace(target, crease_edges=tagged, corners=boundary_corners(target.points, target.boundary_edges))


def _closed(
    points: NDArray[np.float64], triangles: NDArray[np.int64], how: Preparation, name: str
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Points, new ones at the end, and triangles with holes closed where that is asked."""
    if how.fill_holes is None:
        return points, triangles
    filled = fill_holes(points, triangles, how.fill_holes)
    logger.info(
        "%s: closed %s, left %s open", name, counted(filled.filled, "hole"), counted(filled.left, "boundary loop")
    )
    return filled.points, filled.triangles


def _tagged_creases(data: MeshData, rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """The creases that the data themselves name, as rows of the points that stay."""
    place = np.full(len(data.points), -1, np.int64)
    place[rows] = np.arange(len(rows))
    ends = np.sort(place[data.crease_edges[data.crease_sharpness > 0]], axis=1)
    return np.unique(ends[ends[:, 0] >= 0], axis=0)


def _creases(given: Creases | str) -> Creases:
    if given == "auto":
        return "auto"
    if given == "none":
        return "none"
    try:
        angle = math.nan if isinstance(given, bool) else float(given)
    except (TypeError, ValueError):
        angle = math.nan
    if not 0 < angle < 180:
        raise InputError(f"creases is '{given}'; give auto, none, or an angle between 0 and 180 degrees")
    return angle

"""Pictures of a fit, from its result alone."""

import os
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from subdfit.api.interpolation_result import InterpolationResult
from subdfit.api.reconstructing import Reconstruction
from subdfit.api.result import FitResult
from subdfit.api.surface import LimitSurface, Tessellation
from subdfit.api.triangulate import triangles_of
from subdfit.errors import InputError
from subdfit.limit.tessellate import triangles_at
from subdfit.measure import reverse_peaks
from subdfit.target.frame import Frame
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Triangles = NDArray[np.integer]

_TRIANGLES = 200_000
"""About so many triangles are drawn: a panel has not many more pixels."""

_FAR = 0.9
"""Places at this share of the largest distance, and all beyond the tolerance, are coloured however small they are."""


Pictured = FitResult | InterpolationResult | Reconstruction


def picture(path: str | os.PathLike[str], result: Pictured, title: str = "") -> None:
    """Write a PNG of the target, the control mesh on the limit surface, and the distance between the two.

    The distance's colours and numbers are those of the certificate, of both sides.
    Of a cloud, and of a mesh that was interpolated, it shows the points, the polyhedron through them and, where there
    is one, the surface; fitted, with its control mesh.

    Raises
    ------
    InputError
        The target has no faces.
    MachineError
        The file cannot be written.
    """
    if isinstance(result, Reconstruction):
        _polyhedron(path, result, title)
    elif isinstance(result, InterpolationResult):
        mesh = result.given
        _stages(path, mesh.points, (mesh.points, triangles_of(mesh.to_data())), result.surface, title, edges=False)
    elif result.target is None or not result.target.is_mesh:
        raise InputError("a picture needs a target with faces; leave it out for points")
    elif result.target.cloud:
        target = result.target
        _stages(path, target.points[target.used], (target.points, target.triangles), result.surface, title)
    else:
        _mesh_fit(path, result, result.target, title)


def _polyhedron(path: str | os.PathLike[str], result: Reconstruction, title: str) -> None:
    from subdfit.draw.cloud_picture import cloud_picture

    mesh = result.mesh.points, result.mesh.face_vertices.reshape(-1, 3)
    cloud_picture(os.fspath(path), points=result.cloud, mesh=mesh, title=title)


def _stages(
    path: str | os.PathLike[str],
    points: Floats,
    mesh: tuple[Floats, Triangles],
    surface: LimitSurface,
    title: str,
    edges: bool = True,
) -> None:
    """The points, the polyhedron through them, the surface, with the control mesh's edges where these are few."""
    from subdfit.draw.cloud_picture import cloud_picture

    level = _level(surface.domain.face_count)
    drawn = surface.tessellate(level)
    lines = control_edges(surface, 2**level) if edges else None
    cloud_picture(
        os.fspath(path),
        points=points,
        mesh=mesh,
        surface=(drawn.points, drawn.triangles, lines, surface.control_mesh.topology.vertex_count),
        title=title,
    )


def _mesh_fit(path: str | os.PathLike[str], result: FitResult, target: Target, title: str) -> None:
    from subdfit.draw.fit_picture import fit_picture

    measured = result.measurement
    level = _level(result.surface.domain.face_count)
    drawn = result.surface.tessellate(level)
    fit_picture(
        os.fspath(path),
        target=(target.points, target.triangles),
        surface=(drawn.points, drawn.triangles),
        surface_error=_distances_shown(result, target, level, drawn),
        largest=(measured.max, measured.reverse_max),
        control_edges=control_edges(result.surface, 2**level),
        control=(result.control_mesh.points, range(result.control_mesh.topology.face_count)),
        title=title,
        tolerance=result.settings.tolerance.max,
        unit=result.unit,
    )


def _distances_shown(result: FitResult, target: Target, level: int, drawn: Tessellation) -> Floats:
    """The distance that colours each drawn triangle, (t,), as a share of the diagonal.

    It is that of the drawn points. Where footpoints of data and peaks of the surface are beyond the tolerance, or among
    the farthest, it is theirs, on all triangles round the one in which they lie: a peak may be narrower than a pixel.
    """
    frame, measured = Frame.of(target.points[target.used]), result.measurement
    inside = target.normalised(frame)
    surface = result.surface.with_points(frame.inside(result.control_mesh.points))
    drawn_points = inside.tree.closest(frame.inside(drawn.points)).distance
    peaks, data = reverse_peaks(surface, inside), measured.footpoints
    judged = np.delete(np.arange(len(data.distance)), measured.excluded)
    face = np.concatenate([peaks.face, data.face[judged]])
    uv = np.concatenate([peaks.uv, data.uv[judged]])
    distance = np.concatenate([peaks.gap, data.distance[judged]])
    bound = min(_FAR * float(distance.max()), result.settings.tolerance.max or np.inf)
    far = np.flatnonzero(distance >= bound)
    rows = triangles_at(surface.domain, 2**level, face[far], uv[far])
    round_about = np.zeros(len(drawn.points))
    np.maximum.at(round_about, drawn.triangles[rows], distance[far, None])
    shown = np.maximum(drawn_points[drawn.triangles].mean(axis=1), round_about[drawn.triangles].max(axis=1))
    return np.asarray(shown)


def history_picture(path: str | os.PathLike[str], result: FitResult, title: str = "") -> None:
    """Write a PNG of errors, control vertices and seconds by iteration.

    Raises
    ------
    MachineError
        The file cannot be written.
    """
    from subdfit.draw.history_picture import history_picture as draw

    draw(os.fspath(path), [asdict(row) for row in result.history], title=title, tolerance=result.settings.tolerance.max)


def control_edges(surface: LimitSurface, segments: int) -> Floats:
    """Curves on the surface that stand for the control mesh's edges, as (k, 2, 3) segments; each side once."""
    domain = surface.domain
    own = 4 * np.arange(domain.face_count)[:, None] + np.arange(4)
    beyond = 4 * domain.neighbour.astype(np.int64) + domain.neighbour_side
    wanted = domain.present & ((domain.neighbour < 0) | (own < beyond))
    if domain.parts:
        # The sides inside a face end in its middle.
        wanted[:, [1, 2]] = False
    face, side = np.nonzero(wanted)
    t = np.tile(np.linspace(0.0, 1.0, segments + 1), len(face))
    cells = np.repeat(face, segments + 1)
    points = surface.evaluate(cells, domain.along(cells, np.repeat(side, segments + 1), t)).position
    curves = points.reshape(-1, segments + 1, 3)
    return np.stack([curves[:, :-1], curves[:, 1:]], axis=2).reshape(-1, 2, 3)


def _level(cells: int) -> int:
    """Tessellation level at which about `_TRIANGLES` are drawn, from 1 to 4."""
    return int(np.clip(round(np.log(_TRIANGLES / max(cells, 1)) / np.log(4)), 1, 4))

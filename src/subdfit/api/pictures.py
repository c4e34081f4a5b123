"""Pictures of a fit, from its result alone."""

import os
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from subdfit.api.result import FitResult
from subdfit.api.surface import LimitSurface
from subdfit.errors import InputError
from subdfit.target.frame import Frame

Floats = NDArray[np.float64]

_TRIANGLES = 200_000
"""About so many triangles are drawn: a panel has not many more pixels."""

_CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
"""Parameters of a triangular cell's corners."""


def picture(path: str | os.PathLike[str], result: FitResult, title: str = "") -> None:
    """Write a PNG of the target, the control mesh on the limit surface, and the distance between the two.

    Raises
    ------
    InputError
        The target has no faces.
    MachineError
        The file cannot be written.
    """
    from subdfit.draw.fit_picture import fit_picture

    target = result.target
    if target is None or not target.is_mesh:
        raise InputError("a picture needs a target with faces; leave it out for points")
    frame = Frame.of(target.points[target.used])
    level = _level(result.control_mesh.topology.face_count)
    drawn = result.surface.tessellate(level)
    errors = target.normalised(frame).tree.closest(frame.inside(drawn.points)).distance
    fit_picture(
        os.fspath(path),
        target=(target.points, target.triangles),
        surface=(drawn.points, drawn.triangles),
        surface_error=errors,
        control_edges=cell_sides(result.surface, 2**level),
        control=(result.control_mesh.points, range(result.control_mesh.topology.face_count)),
        title=title,
        tolerance=result.settings.tolerance.max,
        unit=result.unit,
    )


def history_picture(path: str | os.PathLike[str], result: FitResult, title: str = "") -> None:
    """Write a PNG of errors, control vertices and seconds by iteration.

    Raises
    ------
    MachineError
        The file cannot be written.
    """
    from subdfit.draw.history_picture import history_picture as draw

    draw(os.fspath(path), [asdict(row) for row in result.history], title=title, tolerance=result.settings.tolerance.max)


def cell_sides(surface: LimitSurface, segments: int) -> Floats:
    """Curves on the surface that stand for the control mesh's edges, as (k, 2, 3) segments; each side once."""
    domain = surface.domain
    own = 3 * np.arange(domain.face_count)[:, None] + np.arange(3)
    beyond = 3 * domain.neighbour[:, :3].astype(np.int64) + domain.neighbour_side[:, :3]
    face, side = np.nonzero((domain.neighbour[:, :3] < 0) | (own < beyond))
    steps = np.linspace(0.0, 1.0, segments + 1)[None, :, None]
    uv = (1 - steps) * _CORNERS[side][:, None] + steps * _CORNERS[(side + 1) % 3][:, None]
    points = surface.evaluate(np.repeat(face, segments + 1), uv.reshape(-1, 2)).position
    curves = points.reshape(-1, segments + 1, 3)
    return np.stack([curves[:, :-1], curves[:, 1:]], axis=2).reshape(-1, 2, 3)


def _level(faces: int) -> int:
    """Tessellation level at which about `_TRIANGLES` are drawn, from 1 to 4."""
    return int(np.clip(round(np.log(_TRIANGLES / max(faces, 1)) / np.log(4)), 1, 4))

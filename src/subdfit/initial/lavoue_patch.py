"""The faces of one patch of a part, from control points on the arcs round it (Lavoué et al. 2007, section 4)."""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.lavoue_contour import topologic_contour
from subdfit.initial.lavoue_cutting import Cutting
from subdfit.initial.lavoue_scores import ScoredSurface
from subdfit.target.curvature import CurvatureField
from subdfit.target.features import mesh_edges
from subdfit.target.network import Loop

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Ring = list[int]

_MOST_REFINEMENTS = 3
"""Of a patch whose triangles are too few for its control points or for a path between its boundaries."""


@dataclass(frozen=True)
class PatchFaces:
    """Faces over control points.

    Attributes
    ----------
    faces : rings of control points.
    open : rings for which there was no control edge: each needs a vertex inside.
    """

    faces: list[Ring]
    open: list[Ring]


def patch_faces(
    surface: ScoredSurface,
    loops: Sequence[Loop],
    chains: Sequence[Indices],
    places: Sequence[Floats],
    points: Floats,
    limits: Floats,
    taken: Set[frozenset[int]],
) -> PatchFaces:
    """Join control points on the boundaries of a patch by control edges along its lines of curvature.

    Parameters
    ----------
    surface : the patch, a disk with holes.
    loops : its boundaries.
    chains, places : control points of each arc, and where they lie along it (see `ControlNetwork`).
    points, limits : (n, 3) float64, all control points and their limits.
    taken : pairs of control points that are joined already.

    Raises
    ------
    InputError
        The boundaries cannot be joined.
    """
    for k in range(_MOST_REFINEMENTS + 1):
        try:
            names, anchors = zip(*(_anchored(loop, chains, places) for loop in loops), strict=True)
            loop_of = np.repeat(np.arange(len(loops)), [len(n) for n in names])
            rows = np.concatenate(names)
            contour = topologic_contour(surface, np.concatenate(anchors), loop_of, points[rows], rows, taken)
            break
        except InputError:
            if k == _MOST_REFINEMENTS:
                raise
            surface, loops = refined(surface, loops)
    cutting = Cutting(contour, points[contour.controls], limits[contour.controls], taken=taken)
    rings = cutting.faces()
    named = [[contour.controls[ring].tolist() for ring in group] for group in (rings, cutting.stuck)]
    if any(len(set(ring)) < len(ring) for ring in named[1]):
        raise InputError("a control point lies on both sides of what is left of a patch")
    return PatchFaces(named[0], named[1])


def _anchored(loop: Loop, chains: Sequence[Indices], places: Sequence[Floats]) -> tuple[Indices, Indices]:
    """Control points round a boundary, and a vertex of it for each, all different and in order."""
    length = len(loop.vertices)
    begins = [*loop.steps[:, 0].tolist(), length]
    names, anchors = [], []
    for k, (begin, arc, along) in enumerate(loop.steps.tolist()):
        chain, share = _directed(chains[arc], places[arc], bool(along))
        if len(loop.steps) > 1 or chain[0] == chain[-1]:
            chain, share = chain[:-1], share[:-1]
        span = begins[k + 1] - begin
        if span < len(chain):
            raise InputError("a boundary has fewer vertices than control points; refine the mesh")
        names.append(chain)
        anchors.append(begin + _spread(np.round(share * span).astype(np.int64), span))
    return np.concatenate(names), loop.vertices[np.concatenate(anchors)]


def _directed(chain: Indices, share: Floats, along: bool) -> tuple[Indices, Floats]:
    """Control points of an arc and their places, in one direction or the other; a closed arc begins where it did."""
    if along:
        return chain, share
    chain, share = chain[::-1], 1 - share[::-1]
    if chain[0] != chain[-1] and len(chain) > 2 and share[0] > 0.0 and share[-1] == 1.0:
        return np.roll(chain, 1), np.roll(share, 1) % 1.0
    return chain, share


def _spread(at: Indices, span: int) -> Indices:
    """Places moved as little as needed to be all different, in order, and below `span`."""
    rank = np.arange(len(at))
    ahead = np.maximum.accumulate(at - rank) + rank
    return np.minimum(ahead, span - len(at) + rank)


def refined(surface: ScoredSurface, loops: Sequence[Loop]) -> tuple[ScoredSurface, list[Loop]]:
    """The same patch with every triangle cut in four."""
    edges = mesh_edges(surface.points, surface.triangles)
    count, t = len(surface.points), np.asarray(surface.triangles, np.int64)
    m = count + edges.of_face
    fine = np.concatenate(
        [
            np.stack([t[:, 0], m[:, 0], m[:, 2]], 1),
            np.stack([t[:, 1], m[:, 1], m[:, 0]], 1),
            np.stack([t[:, 2], m[:, 2], m[:, 1]], 1),
            m,
        ]
    )
    ends = edges.vertices
    tensors, normals = (
        np.concatenate([values, values[ends].mean(axis=1)]) for values in (surface.field.tensors, surface.field.normals)
    )
    size = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    field = CurvatureField(fine, tensors, normals / size)
    points = np.concatenate([surface.points, surface.points[ends].mean(axis=1)])
    row = {(a, b): count + k for k, (a, b) in enumerate(ends.tolist())}
    return replace(surface, points=points, triangles=fine, field=field), [_halved(loop, row) for loop in loops]


def _halved(loop: Loop, row: dict[tuple[int, int], int]) -> Loop:
    v = loop.vertices.tolist()
    middles = [row[min(a, b), max(a, b)] for a, b in zip(v, [*v[1:], v[0]], strict=True)]
    return Loop(np.stack([loop.vertices, middles], axis=1).ravel(), loop.steps * np.array([2, 1, 1]))

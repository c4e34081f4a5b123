"""The topologic contour: one polygon that goes round all boundaries of a surface (Lavoué et al. 2007, Figure 6).

Boundaries are joined by linking edges, one fewer than there are boundaries, and the surface is cut open along the paths
that these stand for. What is left is a disk whose rim runs along every boundary once and along every link twice. On
which side of a link the contour goes on, the paper decides by shortest paths that may not cross links; on the cut mesh
nothing else is possible.
"""

from collections.abc import Set
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.lavoue_scores import ScoredSurface
from subdfit.target.curvature import CurvatureField
from subdfit.target.curves import boundary_loops
from subdfit.target.features import mesh_edges
from subdfit.target.network import cut_open

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_MOST_LINKS = 400
"""Possible links, the shortest by Dijkstra's algorithm, whose geodesics are looked at."""


@dataclass(frozen=True)
class Contour:
    """A disk cut out of a surface, and the control points round its rim.

    Attributes
    ----------
    surface : the cut mesh.
    vertices : (k,) int64, vertices of the cut mesh round its rim, with the surface on the left.
    controls : (k,) int64, the control point that each stands for; those of links occur more than once.
    links : (l, 2) int64, pairs of control points that linking edges join.
    """

    surface: ScoredSurface
    vertices: Indices
    controls: Indices
    links: Indices


def topologic_contour(
    surface: ScoredSurface,
    anchors: Indices,
    loop_of: Indices,
    names: Indices | None = None,
    taken: Set[frozenset[int]] = frozenset(),
) -> Contour:
    """Cut a surface open along the linking edges of least score.

    Parameters
    ----------
    surface : a connected mesh with at least one boundary, without handles.
    anchors : (c,) int64, the boundary vertex at which each control point's limit lies; all different.
    loop_of : (c,) int64, the boundary to which each control point belongs.
    names : (c,) int64, what the control points are called; one that lies on both sides of a cut occurs twice.
    taken : pairs of names that no edge may join any more.

    Raises
    ------
    InputError
        The surface is closed, not connected or has handles, or a boundary cannot be reached.
    """
    loops = boundary_loops(surface.triangles)
    if not loops:
        raise InputError("the surface is closed; segment it into open patches first")
    _require_disk_with_holes(surface, len(loops))
    origin = np.arange(len(surface.points))
    names = np.arange(len(anchors)) if names is None else names
    taken = set(taken)
    joined, links = np.arange(int(loop_of.max()) + 1), []
    for a, b in _candidates(surface, anchors, loop_of):
        link = frozenset((int(names[a]), int(names[b])))
        if joined[loop_of[a]] == joined[loop_of[b]] or len(link) < 2 or link in taken:
            continue
        path = _shortest(surface, np.flatnonzero(origin == anchors[a]), np.flatnonzero(origin == anchors[b]))
        if len(path) == 0:
            continue
        surface, came_from = cut(surface, path)
        origin = origin[came_from]
        joined[joined == joined[loop_of[b]]] = joined[loop_of[a]]
        taken.add(link)
        links.append((int(names[a]), int(names[b])))
    if len(np.unique(joined)) > 1:
        raise InputError("a boundary cannot be linked to the others: its triangles are too few; refine the mesh")
    rim = boundary_loops(surface.triangles)[0].vertices
    control = np.full(len(origin), -1)
    control[anchors] = names
    marked = rim[control[origin[rim]] >= 0]
    return Contour(surface, marked, control[origin[marked]], np.array(links, np.int64).reshape(-1, 2))


def _require_disk_with_holes(surface: ScoredSurface, loops: int) -> None:
    edges = mesh_edges(surface.points, surface.triangles)
    euler = len(np.unique(surface.triangles)) - len(edges.vertices) + len(surface.triangles)
    if euler != 2 - loops:
        raise InputError(
            "the surface has handles or several components; segment it into patches that are disks with holes"
        )


def _candidates(surface: ScoredSurface, anchors: Indices, loop_of: Indices) -> list[tuple[int, int]]:
    """Pairs of control points of different loops, best score first, then shortest."""
    first, second = np.triu_indices(len(anchors), 1)
    different = loop_of[first] != loop_of[second]
    pairs = np.stack([first[different], second[different]], axis=1)
    if len(pairs) == 0:
        return []
    gap = np.linalg.norm(surface.points[anchors[pairs[:, 0]]] - surface.points[anchors[pairs[:, 1]]], axis=1)
    order = np.argsort(gap, kind="stable")
    near = np.zeros(len(pairs), np.bool_)
    near[order[:_MOST_LINKS]] = True
    ends = [(int(anchors[a]), int(anchors[b])) for a, b in pairs[near]]
    score, length = surface.scores(surface.find(ends))
    best = pairs[near][np.lexsort((length, np.round(score, 6)))]
    # Boundaries far from all others are linked by what is left, the shortest first.
    return [(int(a), int(b)) for a, b in [*best, *pairs[order[_MOST_LINKS:]]]]


def _shortest(surface: ScoredSurface, sources: Indices, targets: Indices) -> Indices:
    """Shortest of the paths along edges between copies of two vertices."""
    paths = [surface.edge_path(int(a), int(b)) for a in sources for b in targets]
    found = [path for path in paths if len(path) > 1]
    if not found:
        return np.empty(0, np.int64)
    return min(found, key=lambda path: float(np.linalg.norm(np.diff(surface.points[path], axis=0), axis=1).sum()))


def cut(surface: ScoredSurface, path: Indices) -> tuple[ScoredSurface, Indices]:
    """Cut a mesh open along edges: every vertex becomes one for each fan that the cut leaves.

    Parameters
    ----------
    surface : the mesh.
    path : (k,) vertices, neighbours joined by edges.

    Returns
    -------
    surface : the mesh after the cut, with the curvature of before.
    origin : (n',) int64, the vertex of before that each stands for.
    """
    opened, origin = cut_open(surface.triangles, np.stack([path[:-1], path[1:]], axis=1))
    field = CurvatureField(opened, surface.field.tensors[origin], surface.field.normals[origin])
    return replace(surface, points=surface.points[origin], triangles=opened, field=field), origin

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
from subdfit.initial.lavoue_crossing import Edges
from subdfit.initial.lavoue_scores import DIGITS, ScoredSurface
from subdfit.limit.curvature import unit
from subdfit.mesh.checks import row_numbers
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
    points: Floats | None = None,
    names: Indices | None = None,
    taken: Set[frozenset[int]] = frozenset(),
) -> Contour:
    """Cut a surface open along the linking edges of least score.

    Parameters
    ----------
    surface : a connected mesh with at least one boundary, without handles.
    anchors : (c,) int64, the boundary vertex at which each control point's limit lies; all different.
    loop_of : (c,) int64, the boundary to which each control point belongs; those of one follow each other round it.
    points : (c, 3) float64, the control points; default where they are anchored.
    names : (c,) int64, what the control points are called; one that lies on both sides of a cut occurs twice.
    taken : pairs of names that no edge may join any more.

    Raises
    ------
    InputError
        The surface is closed, not connected or has handles, anchors are no vertices of its boundary, or a boundary
        cannot be reached.
    """
    loops = boundary_loops(surface.triangles)
    if not loops:
        raise InputError("the surface is closed; segment it into open patches first")
    _require_disk_with_holes(surface, len(loops))
    anchors, loop_of = _checked(surface, anchors, loop_of, len(loops))
    names = np.arange(len(anchors)) if names is None else names
    points = surface.points[anchors] if points is None else points
    surface = passable(surface)
    opening = _Opening(surface, anchors, loop_of, points, names, taken)
    pairs = _candidates(surface, anchors, loop_of)
    # A link that crosses an edge is better than none.
    for crossing in (False, True):
        for a, b in pairs:
            opening.link(a, b, crossing)
    return opening.contour()


def _checked(surface: ScoredSurface, anchors: Indices, loop_of: Indices, loops: int) -> tuple[Indices, Indices]:
    """Anchors and the boundaries to which they belong; raises InputError where they cannot be."""
    anchors = row_numbers(anchors, len(surface.points), "anchors")
    loop_of = row_numbers(loop_of, loops, "boundaries of anchors")
    if len(loop_of) != len(anchors) or len(anchors) == 0:
        raise InputError(f"{len(loop_of)} boundaries for {len(anchors)} anchors; give one for each of one or more")
    inside = anchors[~surface.boundary[anchors]]
    if len(inside):
        raise InputError(f"anchor {inside[0]} lies inside the surface; give vertices of its boundary")
    if len(np.unique(anchors)) < len(anchors):
        raise InputError("two anchors are the same vertex; give each control point its own")
    return anchors, loop_of


class _Opening:
    """A surface on its way to a disk: cut open along linking edges, one at a time; arguments of `topologic_contour`."""

    def __init__(
        self,
        surface: ScoredSurface,
        anchors: Indices,
        loop_of: Indices,
        points: Floats,
        names: Indices,
        taken: Set[frozenset[int]],
    ) -> None:
        self._whole = self._surface = surface
        self._anchors, self._loop_of, self._points, self._names = anchors, loop_of, points, names
        self._taken = set(taken)
        self._edges = _polygon_sides(surface, anchors, loop_of, points)
        # Vertices of the surface before all cuts; -1 for those that cuts have put on edges since.
        self._origin = np.arange(len(surface.points))
        self._joined = np.arange(int(loop_of.max()) + 1)
        self._links: list[tuple[int, int]] = []

    def link(self, a: int, b: int, crossing: bool) -> None:
        """Join the boundaries of two control points, unless they are, by an edge that may cross others or not."""
        link = frozenset((int(self._names[a]), int(self._names[b])))
        one, other = self._joined[self._loop_of[[a, b]]]
        if one == other or len(link) < 2 or link in self._taken:
            return
        geodesic = self._whole.find([(int(self._anchors[a]), int(self._anchors[b]))], "geodesic")[0]
        edge = Edges(np.array([[a, b]]), self._points[[[a, b]]], self._whole.mean_normals([geodesic]))
        if not crossing and self._edges.crossed_by(edge):
            return
        begin, end = (np.flatnonzero(self._origin == self._anchors[k]) for k in (a, b))
        path = self._surface.edge_path(begin, end, geodesic)
        if len(path) < 2:
            return
        self._cut(path)
        self._edges = self._edges.joined(edge)
        self._joined[self._joined == other] = one
        self._taken.add(link)
        self._links.append((int(self._names[a]), int(self._names[b])))

    def _cut(self, path: Indices) -> None:
        opened, came_from = cut(self._surface, path)
        self._surface, kept = passable(opened), self._origin[came_from]
        self._origin = np.full(len(self._surface.points), -1)
        self._origin[: len(kept)] = kept

    def contour(self) -> Contour:
        """The disk that is left; raises InputError where boundaries are left that nothing links."""
        if len(np.unique(self._joined)) > 1:
            raise InputError("a boundary cannot be linked to the others: its triangles are too few; refine the mesh")
        rim, origin = boundary_loops(self._surface.triangles)[0].vertices, self._origin
        control = np.full(origin.max() + 1, -1)
        control[self._anchors] = self._names
        marked = rim[(origin[rim] >= 0) & (control[origin[rim]] >= 0)]
        return Contour(self._surface, marked, control[origin[marked]], np.array(self._links, np.int64).reshape(-1, 2))


def _require_disk_with_holes(surface: ScoredSurface, loops: int) -> None:
    edges = mesh_edges(surface.points, surface.triangles)
    euler = len(np.unique(surface.triangles)) - len(edges.vertices) + len(surface.triangles)
    if euler != 2 - loops:
        raise InputError(
            "the surface has handles or several components; segment it into patches that are disks with holes"
        )


def _polygon_sides(surface: ScoredSurface, anchors: Indices, loop_of: Indices, points: Floats) -> Edges:
    """The control edges along the boundaries."""
    around = [np.flatnonzero(loop_of == loop) for loop in np.unique(loop_of)]
    ends = np.concatenate([np.stack([rows, np.roll(rows, -1)], axis=1) for rows in around])
    return Edges(ends, points[ends], unit(surface.field.normals[anchors[ends]].sum(axis=1)))


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
    best = pairs[near][np.lexsort((length, np.round(score, DIGITS)))]
    # Boundaries far from all others are linked by what is left, the shortest first.
    return [(int(a), int(b)) for a, b in [*best, *pairs[order[_MOST_LINKS:]]]]


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


def passable(surface: ScoredSurface) -> ScoredSurface:
    """The same surface, edges inside between two vertices of its boundary cut in two, so that paths pass between."""
    edges = mesh_edges(surface.points, surface.triangles)
    barring = (edges.valence == 2) & surface.boundary[edges.vertices].all(axis=1)
    ends, count = edges.vertices[barring], len(surface.points)
    middle = np.full(len(barring), -1)
    middle[barring] = count + np.arange(len(ends))
    triangles = _divided(np.asarray(surface.triangles, np.int64), middle[edges.of_face])
    tensors, normals = (
        np.concatenate([values, values[ends].mean(axis=1)]) for values in (surface.field.tensors, surface.field.normals)
    )
    field = CurvatureField(triangles, tensors, unit(normals))
    points = np.concatenate([surface.points, surface.points[ends].mean(axis=1)])
    return replace(surface, points=points, triangles=triangles, field=field)


def _divided(triangles: Indices, middle: Indices) -> Indices:
    """Triangles cut at the middles of their sides, (m, 3), -1 for sides that stay whole."""
    some = np.any(middle >= 0, axis=1)
    parts = []
    for corners, on in zip(triangles[some].tolist(), middle[some].tolist(), strict=True):
        ring = [v for pair in zip(corners, on, strict=True) for v in pair if v >= 0]
        while len(ring) > 3:
            # The corner with most middles beside it goes; a middle would leave a triangle without area.
            beside = [(ring[k - 1] in on) + (ring[(k + 1) % len(ring)] in on) for k in range(len(ring))]
            ear = max((k for k in range(len(ring)) if ring[k] in corners), key=beside.__getitem__)
            parts.append([ring[ear - 1], ring[ear], ring[(ear + 1) % len(ring)]])
            del ring[ear]
        parts.append(ring)
    return np.concatenate([triangles[~some], np.array(parts, np.int64).reshape(-1, 3)])

"""Close small holes of a triangle mesh with the triangles that bend least."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.initial._holes_kernels import triangulate_rim
from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class FilledMesh:
    """A triangle mesh with holes closed.

    Attributes
    ----------
    points : (n + added, 3) float64, the input's points and then one centre for each hole that needed it.
    triangles : (m + new, 3) int64, the input's triangles and then the new ones.
    filled : number of holes closed.
    left : number of boundary loops that are too long and stay open.
    """

    points: Floats
    triangles: Rows
    filled: int
    left: int


def fill_holes(points: ArrayLike, triangles: ArrayLike, max_edges: int) -> FilledMesh:
    """Close every boundary loop of at most `max_edges` edges.

    A loop is triangulated without new points, its worst dihedral angle least and then its area, over all
    triangulations that keep the mesh manifold. Where there is none, a fan round a new point closes it.
    Time grows with the cube of a loop's length: a loop of 100 edges takes about 10 ms.

    Parameters
    ----------
    points : (n, 3)
        Positions, in any unit.
    triangles : (m, 3)
        An oriented manifold in which every point is used.
    max_edges : int
        Edges of the longest loop to close; anything below 3 closes none.

    Raises
    ------
    InputError
        The triangles are no oriented manifold.

    References
    ----------
    Liepa, Filling holes in meshes, Symposium on Geometry Processing 2003.
    """
    positions = np.array(points, np.float64, order="C").reshape(-1, 3)
    if not np.isfinite(positions).all():
        row = int(np.flatnonzero(~np.isfinite(positions).all(axis=1))[0])
        raise InputError(f"point {row} is not finite; remove it and its faces")
    topology = Topology.from_triangles(triangles, len(positions))
    loops = boundary_loops(topology)
    small = [loop for loop in loops if len(loop) <= max_edges]
    neighbours = _rim_neighbours(topology, small)
    pieces = [np.asarray(triangles, np.int64).reshape(-1, 3)]
    centres: list[Floats] = []
    for loop in small:
        fill, centred = _fill_loop(topology, positions, loop, neighbours, len(positions) + len(centres))
        pieces.append(fill)
        if centred:
            centres.append(positions[topology.face_vertices[loop]].mean(axis=0))
    return FilledMesh(
        points=np.concatenate([positions, np.array(centres).reshape(-1, 3)]),
        triangles=np.concatenate(pieces),
        filled=len(small),
        left=len(loops) - len(small),
    )


def boundary_loops(topology: Topology) -> list[Rows]:
    """Return the half-edges without a twin, loop by loop, in the order in which the faces run.

    Each loop starts at its lowest half-edge; the loops come in the order of these.
    """
    open_edges = np.flatnonzero(topology.twin < 0)
    heads = topology.face_vertices[topology.following[open_edges]]
    after = dict(zip(open_edges.tolist(), topology.outgoing[heads].tolist(), strict=True))
    loops = []
    while after:
        h = next(iter(after))
        loop = []
        while h in after:
            loop.append(h)
            h = after.pop(h)
        loops.append(np.array(loop, np.int64))
    return loops


def _rim_neighbours(topology: Topology, loops: list[Rows]) -> dict[int, list[int]]:
    """Give, for each vertex on one of the loops, the vertices that edges join to it."""
    on_rim = np.zeros(topology.vertex_count, np.bool_)
    for loop in loops:
        on_rim[topology.face_vertices[loop]] = True
    ends = topology.edge_vertices
    neighbours: dict[int, list[int]] = {}
    for a, b in ends[on_rim[ends].all(axis=1)].tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    return neighbours


def _fill_loop(
    topology: Topology, points: Floats, loop: Rows, neighbours: dict[int, list[int]], centre: int
) -> tuple[Rows, bool]:
    """Triangles that close one loop, and whether they use the new point with row `centre`."""
    # The fill runs against the faces beyond the rim, so the rim is walked backwards.
    edges = loop[::-1]
    rim = topology.face_vertices[topology.following[edges]].astype(np.int64)
    slot = {vertex: i for i, vertex in enumerate(rim.tolist())}
    taken = np.zeros((len(rim), len(rim)), np.bool_)
    for vertex, i in slot.items():
        for other in neighbours[vertex]:
            if other in slot:
                taken[i, slot[other]] = True
    faces = topology.face[edges]
    a, b, c = (points[topology.face_vertices[3 * faces + i]] for i in range(3))
    lone_triangle = len(rim) == 3 and faces[0] == faces[1] == faces[2]
    if not lone_triangle:
        fill, found = triangulate_rim(points[rim], np.cross(b - a, c - a), taken)
        if found:
            return rim[fill], False
    return np.stack([rim, np.roll(rim, -1), np.full(len(rim), centre)], axis=1), True

"""The network of curves along which a part is cut into patches: arcs between nodes, and the patches between arcs."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from subdfit.target.curves import Curve, boundary_loops, curves
from subdfit.target.features import edges_among, mesh_edges

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Arc:
    """A chain of vertices between two nodes, or round a loop without nodes.

    Attributes
    ----------
    vertices : (k,) int64, rows of the points; a closed arc does not repeat its first vertex, an open one may begin and
        end at the same node.
    closed : whether the last vertex is joined to the first.
    sharp : whether the surface may bend sharply there; else two patches meet smoothly.
    exact : whether the arc lies on a crease or the boundary; others run along edges of the mesh, in steps.
    """

    vertices: Indices
    closed: bool
    sharp: bool
    exact: bool


@dataclass(frozen=True)
class Loop:
    """One boundary of a patch, with the patch on the left.

    Attributes
    ----------
    vertices : (k,) int64, vertices of the patch, each once.
    steps : (s, 3) int64, the arcs along it: place in `vertices` at which each begins, the arc, and whether it is run
        along (1) or against (0) its own direction.
    """

    vertices: Indices
    steps: Indices


@dataclass(frozen=True)
class Patch:
    """A piece of the mesh between arcs.

    Attributes
    ----------
    faces : (t,) int64, rows of the mesh's triangles.
    triangles : (t, 3) int64, by the patch's own vertices.
    origin : (v,) int64, the point that each of its vertices is; one may occur twice, on both sides of an arc.
    loops : its boundaries.
    """

    faces: Indices
    triangles: Indices
    origin: Indices
    loops: tuple[Loop, ...]

    @property
    def is_disk_with_holes(self) -> bool:
        """Whether the patch has a boundary and no handles."""
        ends = np.unique(np.sort(self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
        euler = len(self.origin) - len(ends) + len(self.triangles)
        return len(self.loops) > 0 and euler == 2 - len(self.loops)


@dataclass(frozen=True)
class Cuts:
    """Edges along which a mesh is cut into patches, its boundary among them.

    Attributes
    ----------
    edges : (e, 2) int64.
    sharp, exact : (e,) bool, see `Arc`.
    """

    edges: Indices
    sharp: Flags
    exact: Flags


@dataclass(frozen=True)
class Network:
    """Arcs, and the patches that they leave."""

    arcs: tuple[Arc, ...]
    patches: tuple[Patch, ...]


def curve_network(triangles: NDArray[np.integer], cuts: Cuts, nodes: Indices | None = None) -> Network:
    """Cut a mesh into patches along edges.

    Parameters
    ----------
    triangles : (m, 3) int, an oriented manifold.
    cuts : where to cut.
    nodes
        Vertices at which arcs end in any case, such as sharp points. Other nodes are those where more or fewer than two
        edges meet, or two of different kinds.
    """
    arcs = network_arcs(cuts, nodes)
    opened, origin = cut_open(triangles, cuts.edges)
    place = {}
    for number, arc in enumerate(arcs):
        ends = Curve(arc.vertices, arc.closed).edges
        for step, (a, b) in enumerate(ends.tolist()):
            place[a, b] = (step == 0, number, 1)
            place[b, a] = (step == len(ends) - 1, number, 0)
    count, piece = pieces(opened)
    patches = []
    for k in range(count):
        faces = np.flatnonzero(piece == k)
        used, local = np.unique(opened[faces], return_inverse=True)
        local, own = local.reshape(-1, 3), origin[used]
        loops = tuple(_loop(curve.vertices, own, place) for curve in boundary_loops(local))
        patches.append(Patch(faces, local, own, loops))
    return Network(tuple(arcs), tuple(patches))


def network_arcs(cuts: Cuts, nodes: Indices | None = None) -> list[Arc]:
    """Chain edges to arcs; arguments as in `curve_network`."""
    size = int(cuts.edges.max(initial=0)) + 1
    kind = 2 * cuts.sharp.astype(np.int64) + cuts.exact
    degree = np.bincount(cuts.edges.ravel(), minlength=size)
    is_node = degree != 2
    for one in np.unique(kind):
        is_node |= np.bincount(cuts.edges[kind == one].ravel(), minlength=size) == 1
    if nodes is not None:
        is_node[nodes] = True
    return [
        Arc(part, closed, one >= 2, one % 2 == 1)
        for one in (3, 2, 0)
        for curve in curves(cuts.edges[kind == one])
        for part, closed in _parts(curve, is_node)
    ]


def _parts(curve: Curve, is_node: Flags) -> list[tuple[Indices, bool]]:
    """A chain cut at the nodes on it."""
    inner, v = np.flatnonzero(is_node[curve.vertices]), curve.vertices
    if not curve.closed:
        stops = np.unique([0, *inner, len(v) - 1])
        return [(v[a : b + 1], False) for a, b in pairwise(stops.tolist())]
    if len(inner) == 0:
        return [(v, True)]
    turned = np.concatenate([v[inner[0] :], v[: inner[0] + 1]])
    stops = np.concatenate([inner - inner[0], [len(v)]])
    return [(turned[a : b + 1], False) for a, b in pairwise(stops.tolist())]


def cut_open(triangles: NDArray[np.integer], edges: Indices) -> tuple[Indices, Indices]:
    """Cut a mesh open along edges: every vertex becomes one for each fan that the cut leaves.

    Parameters
    ----------
    triangles : (m, 3) int.
    edges : (e, 2) int, in any order.

    Returns
    -------
    triangles : (m, 3) int64, by the new vertices.
    origin : (n',) int64, the old vertex that each was.
    """
    triangles = np.asarray(triangles, np.int64)
    size = int(triangles.max()) + 1
    found = mesh_edges(np.zeros((size, 3)), triangles)
    whole = (found.valence == 2) & ~edges_among(found.vertices, edges)
    faces, ends = found.faces[whole], found.vertices[whole]
    corner = [
        [3 * faces[:, side] + np.argmax(triangles[faces[:, side]] == ends[:, k, None], axis=1) for k in range(2)]
        for side in range(2)
    ]
    one, other = np.concatenate(corner[0]), np.concatenate(corner[1])
    links = coo_array((np.ones(len(one), np.int8), (one, other)), shape=(triangles.size, triangles.size))
    count, fan = connected_components(links, directed=False)
    origin = np.empty(count, np.int64)
    origin[fan] = triangles.ravel()
    return fan.reshape(-1, 3).astype(np.int64), origin


def pieces(triangles: Indices) -> tuple[int, Indices]:
    """Connected pieces of a mesh: their number, and that of each triangle."""
    ends = np.concatenate([triangles[:, :2], triangles[:, 1:]])
    size = int(triangles.max()) + 1
    links = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(size, size))
    count, piece = connected_components(links, directed=False)
    return count, np.asarray(piece[triangles[:, 0]], np.int64)


def _loop(vertices: Indices, origin: Indices, place: dict[tuple[int, int], tuple[bool, int, int]]) -> Loop:
    """A boundary turned so that it begins where an arc does."""
    own = origin[vertices].tolist()
    rows = [place[a, b] for a, b in zip(own, [*own[1:], own[0]], strict=True)]
    first = next(k for k, row in enumerate(rows) if row[0])
    rows = rows[first:] + rows[:first]
    steps = [(k, arc, along) for k, (begins, arc, along) in enumerate(rows) if begins]
    return Loop(np.roll(vertices, -first), np.array(steps, np.int64))

"""Whether a mesh through points runs to and fro between two sheets that lie nearer than its points.

A sheet of noise and two sheets joined to one are rough alike. But over the plane of a neighbourhood the points of two
sheets lie in two smooth layers with nothing in between. That stays so when the thin direction is stretched, as it has
to where an axis is in a smaller unit than the others: the answer does not depend on how thin the cloud is.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from subdfit.mesh.topology import Topology

Floats = NDArray[np.float64]
Rows = NDArray[np.int64]
Flags = NDArray[np.bool_]

SOME_VERTICES = 2000
"""At how many vertices, at most twice, layers are looked for."""

LEAST_VERTICES = 50
"""So few vertices are as good as this number: one of them may show layers by chance."""

LEAST_IN_LAYER = 6
"""Points of a layer, twice what a plane needs."""

ROUNDS = 3
"""Rounds in which points choose the nearer layer, and layers follow."""

THIN = 0.2
"""Roughness of two layers, as a share of the one sheet's, below which they are two: noise cut in two halves keeps half
of its own if uniform, six tenths if Gaussian."""

APART = 0.5
"""Distance of the layers' centres in the plane, as a share of the neighbourhood's radius, from which they lie side by
side, like the treads of a step or the faces at an edge: those of half discs are .85 apart."""

PARALLEL = 0.5
"""Spread of the gap between the layers, as a share of its mean, below which neither crosses the other."""


def share_of_joined_sheets(points: Floats, topology: Topology, flat: float) -> float:
    """Share of the inner vertices round which the mesh joins two sheets.

    Parameters
    ----------
    points : (n, 3) float64.
    topology : of a triangle mesh in which all points are used.
    flat : roughness up to which a neighbourhood is one plane.
    """
    near, known = _two_rings(topology)
    if not len(near):
        return 0.0
    places, heights = _over_planes(points[near], known)
    rough = _rms(heights, known)
    parts = _parts(places, heights, known)
    layers = [_planes(places, heights, part) for part in parts]
    within = _rms(heights - np.where(parts[0], *layers), known)
    full = np.minimum(*(part.sum(axis=1) for part in parts)) >= LEAST_IN_LAYER
    two = full & (rough > flat) & (within < THIN * rough) & _parallel(layers[0] - layers[1], known)
    return float(np.count_nonzero(two & (_distance(places, *parts) < APART)) / max(len(near), LEAST_VERTICES))


def _two_rings(topology: Topology) -> tuple[Rows, Flags]:
    """Some vertices with neighbours and these' neighbours, (s, k), padded, and which entries are known.

    Not those from which two steps lead to a boundary: three rows of points of a curved sheet are like two layers.
    """
    count, each = topology.vertex_count, np.arange(topology.vertex_count)
    ends = np.concatenate([topology.edge_vertices, topology.edge_vertices[:, ::-1], np.stack([each, each], axis=1)])
    joined: csr_array = coo_array(
        (np.ones(len(ends), np.int32), (ends[:, 0], ends[:, 1])), shape=(count, count)
    ).tocsr()
    rings = joined[:: -(-count // SOME_VERTICES)] @ joined
    rings = rings[np.flatnonzero(rings @ topology.boundary_vertices == 0)]
    sizes = np.diff(rings.indptr)
    known: Flags = np.arange(sizes.max(initial=0)) < sizes[:, None]
    near = np.zeros(known.shape, np.int64)
    near[known] = rings.indices
    return near, known


def _over_planes(points: Floats, known: Flags) -> tuple[Floats, Floats]:
    """Places (s, k, 2) in the plane of least squares, the radius of a disc being 1, and heights over it (s, k)."""
    weight = known / known.sum(axis=1, keepdims=True)
    across = points - np.einsum("sk,skd->sd", weight, points)[:, None]
    sizes, axes = np.linalg.eigh(np.einsum("sk,ski,skj->sij", weight, across, across))
    local = np.einsum("ski,sij->skj", across, axes)
    radius = np.sqrt(2.0 * (sizes[:, 1] + sizes[:, 2]))
    places = local[:, :, 1:] / radius[:, None, None]
    return places, local[:, :, 0] - _planes(places, local[:, :, 0], known)


def _parts(places: Floats, heights: Floats, known: Flags) -> tuple[Flags, Flags]:
    """The points of the upper and of the lower layer."""
    upper = known & (heights > 0)
    for _ in range(ROUNDS):
        above, below = (_planes(places, heights, part) for part in (upper, known & ~upper))
        upper = known & (np.abs(heights - above) < np.abs(heights - below))
    return upper, known & ~upper


def _planes(places: Floats, heights: Floats, part: Flags) -> Floats:
    """Heights (s, k) at all places of the planes of least squares through a part of the points."""
    base = np.concatenate([np.ones((*heights.shape, 1)), places], axis=2)
    normal = np.einsum("sk,ski,skj->sij", part, base, base) + 1e-9 * np.eye(3)  # if few points, or all in a row
    right = np.einsum("sk,ski,sk->si", part, base, heights)
    found: Floats = np.einsum("ski,si->sk", base, np.linalg.solve(normal, right[:, :, None])[:, :, 0])
    return found


def _rms(heights: Floats, known: Flags) -> Floats:
    size: Floats = np.sqrt(np.mean(heights**2, axis=1, where=known))
    return size


def _parallel(gap: Floats, known: Flags) -> Flags:
    """Whether one plane's height over another hardly differs between the points."""
    mean = np.mean(gap, axis=1, where=known)
    parallel: Flags = _rms(gap - mean[:, None], known) < PARALLEL * np.abs(mean)
    return parallel


def _distance(places: Floats, upper: Flags, lower: Flags) -> Floats:
    """Distance of the centres of two parts."""
    above, below = (
        np.einsum("sk,skd->sd", part, places) / np.maximum(part.sum(axis=1, keepdims=True), 1)
        for part in (upper, lower)
    )
    distance: Floats = np.linalg.norm(above - below, axis=1)
    return distance

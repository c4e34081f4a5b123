"""Where a segmented part is cut into patches that are disks with holes, as control meshes from boundaries need them.

Lavoué et al. 2007 take open surfaces without handles only. A patch that is a sphere or a torus, or has a handle, is cut
halfway between two far points of it, which makes two caps of a sphere and two tubes of a torus.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.network import Cuts, Patch, curve_network, cut_open, pieces
from subdfit.target.segmentation_tips import continued, led_along_borders

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]


def part_cuts(points: Floats, triangles: NDArray[np.integer], labels: Labels, creases: NDArray[np.int64]) -> Cuts:
    """Borders of regions, and creases within one.

    Creases that cut off a piece of a region are left out, since segmentation took the piece for a remnant; those that
    end inside one are led on, so that no sharp arc ends but where it meets others.

    Parameters
    ----------
    points, triangles : the mesh.
    labels : (m,) int64, the regions.
    creases : (c, 2) int64.
    """
    edges = mesh_edges(points, triangles)
    crease = edges_among(edges.vertices, creases)
    inner = edges.valence == 2
    border = inner & (labels[edges.faces[:, 0]] != labels[edges.faces[:, 1]])
    _, piece = pieces(cut_open(triangles, edges.vertices[crease | border])[0])
    sides = piece[edges.faces]
    crease &= border | (sides[:, 0] == sides[:, 1])
    exact = crease | ~inner
    led = continued(points, edges, exact | border)
    sharp = led_along_borders(points, edges, exact | led, border)
    kept = sharp | border
    return Cuts(edges.vertices[kept], sharp[kept], exact[kept])


def without_handles(points: Floats, triangles: NDArray[np.integer], cuts: Cuts) -> Cuts:
    """More cuts, until every patch is a disk with holes."""
    while True:
        patches = curve_network(triangles, cuts).patches
        bad = [patch for patch in patches if not patch.is_disk_with_holes]
        if not bad:
            return cuts
        for patch in bad:
            cuts = halved(points, patch, cuts)


def halved(points: Floats, patch: Patch, cuts: Cuts) -> Cuts:
    """The cuts, and one through a patch of two triangles or more: halfway between two far vertices of it."""
    own = points[patch.origin]
    edges = mesh_edges(own, patch.triangles)
    length = np.maximum(np.linalg.norm(own[edges.vertices[:, 1]] - own[edges.vertices[:, 0]], axis=1), 1e-300)
    both = np.concatenate([edges.vertices, edges.vertices[:, ::-1]])
    graph = csr_array((np.tile(length, 2), (both[:, 0], both[:, 1])), shape=(len(own), len(own)))
    start = dijkstra(graph, indices=[0])[0]
    near = dijkstra(graph, indices=[int(np.argmax(start))])[0]
    far = dijkstra(graph, indices=[int(np.argmax(near))])[0]
    nearer = (near - far)[patch.triangles].sum(axis=1)
    second = nearer > 0
    if second.all() or not second.any():
        second = np.arange(len(nearer)) == int(np.argmax(nearer))
    between = (edges.valence == 2) & (second[edges.faces[:, 0]] != second[edges.faces[:, 1]])
    fresh = np.sort(patch.origin[edges.vertices[between]], axis=1)
    smooth = np.zeros(len(fresh), np.bool_)
    flags = (np.concatenate([kind, smooth]) for kind in (cuts.sharp, cuts.exact))
    return Cuts(np.concatenate([cuts.edges, fresh]), *flags)

"""Segmentation of a part into faces: regions of like curvature between sharp edges.

The steps are those of Lavoué, Dupont and Baskurt, A new CAD mesh segmentation method, based on curvature tensor
analysis, 2005: curvature of every triangle, classes of curvature, regions grown from them, regions merged, borders
rectified. What is ours is said in the modules of the steps, each of which can be called alone.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from subdfit.errors import InputError
from subdfit.target.bvh import TriangleTree
from subdfit.target.features import automatic_creases, edges_among, mesh_edges
from subdfit.target.segmentation_carrying import on_all_triangles
from subdfit.target.segmentation_clusters import cluster, grow
from subdfit.target.segmentation_facets import Facets, Flags, Labels
from subdfit.target.segmentation_gaps import crease_gaps
from subdfit.target.segmentation_meeting import where_faces_meet
from subdfit.target.segmentation_merging import Adjacency, absorb, merge_regions, renumbered
from subdfit.target.segmentation_noise import noise_of, without_noise
from subdfit.target.segmentation_planes import with_planes
from subdfit.target.segmentation_rectification import border_costs, rectify
from subdfit.target.segmentation_slivers import FOLDED, without_slivers
from subdfit.target.segmentation_tips import across_necks
from subdfit.target.target import Target

Floats = NDArray[np.float64]
Triangles = NDArray[np.int32]
Creases = NDArray[np.int64]

_SPACING = 1.5
_ROUNDS = 2
_THIN, _NOTHING = 0.5, 0.05
"""Widths, in radii, below which a region is a remnant beside a smooth border, and beside a sharp one. So is one smaller
than a ball, and open on most sides: its curvature was never seen by itself."""
_HAIR = 0.002
"""Width, in diagonals, from which a region between sharp edges is a face however coarse the mesh: a plate's rim."""
_SHORTEST = 4.0
"""Length, in radii, of the shortest sharp edges that count where they part no regions."""


@dataclass(frozen=True)
class SegmentationSettings:
    """How finely a part is segmented.

    Attributes
    ----------
    radius : of the balls over which curvature is averaged, in the mesh's unit; None takes 1.5 median edges. Fillets
        narrower than that are not told apart.
    classes : number of classes of curvature with which regions begin.
    step_turn, least_turn : degrees by which two neighbours differ at least, judged by their mean curvatures at first,
        and by the curvatures on both sides of their border at the end (see `segmentation_merging`).
    """

    radius: float | None = None
    classes: int = 12
    step_turn: float = 4.0
    least_turn: float = 10.0

    def __post_init__(self) -> None:
        if self.radius is not None and not self.radius > 0:
            raise InputError(f"radius is {self.radius}; give a positive length in the mesh's unit")
        if self.classes < 1:
            raise InputError(f"classes is {self.classes}; give 1 or more")


@dataclass(frozen=True)
class Regions:
    """A segmented mesh.

    Attributes
    ----------
    labels : (m,) int64, the region of each triangle, from 0 in the order in which triangles meet them.
    feature_edges : (c, 2) int64, rows of the points: edges that are sharp, between regions or within one.
    """

    labels: Labels
    feature_edges: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of regions."""
        return int(self.labels.max()) + 1


def segment_mesh(target: Target, settings: SegmentationSettings | None = None, *, find_creases: bool = True) -> Regions:
    """Segment a mesh into its faces.

    Parameters
    ----------
    target : a mesh; its crease edges part regions.
    settings : default `SegmentationSettings()`.
    find_creases : look for creases anew where needles, triangles too low to have a normal, hid them.

    Raises
    ------
    InputError
        The target has no triangles.
    """
    if not target.is_mesh:
        raise InputError("segmentation needs a mesh; reconstruct one from the points first")
    settings = settings or SegmentationSettings()
    points, triangles, creases = target.points, target.triangles, target.crease_edges
    noise = noise_of(points, triangles, creases)
    if noise == 0.0:
        return _segment(points, triangles, creases, settings, find_creases)
    coarse = without_noise(points, triangles, creases, noise)
    creases = automatic_creases(coarse.points, coarse.triangles) if find_creases else coarse.edges(creases)
    found = _segment(coarse.points, coarse.triangles, creases, settings, find_creases)
    features = found.feature_edges
    if find_creases:
        gaps = crease_gaps(coarse.points, coarse.triangles, found.labels, features)
        features = np.concatenate([features, gaps])
    carried = on_all_triangles(points, triangles, coarse, found.labels, features)
    labels, features = where_faces_meet(points, triangles, *carried, noise)
    return Regions(renumbered(labels), features)


def _segment(
    points: Floats, triangles: Triangles, creases: Creases, settings: SegmentationSettings, find_creases: bool
) -> Regions:
    """Segment a mesh without noise."""
    upright, creases = without_slivers(points, triangles, creases, found=find_creases)
    changed = np.any(upright != triangles, axis=1)
    facets = _facets(points, upright, creases, settings.radius)
    labels = segment_facets(facets, settings)
    features = facets.edges.vertices[_features(facets, labels)]
    return _on_target(triangles, facets, changed, labels, features)


def segment_facets(facets: Facets, settings: SegmentationSettings) -> Labels:
    """Regions of triangles, (m,): classes, growing, merging, and borders rectified."""
    ball = np.pi * facets.radius**2
    facets = replace(facets, sharp=facets.sharp | across_necks(facets, ball))
    curvatures, directions = facets.curvature()
    # Logarithmic for radii far below the part's size, so that small fillets do not take up all classes.
    classes = cluster(np.arcsinh(curvatures * facets.diagonal / 2), facets.areas, settings.classes)
    labels = grow(facets, classes)
    labels = merge_regions(facets, labels, curvatures, Adjacency.turn_of_means, settings.step_turn)
    costs = border_costs(facets, directions)
    for _ in range(_ROUNDS):
        one_sided, _ = facets.curvature(facets.borders(labels))
        labels = merge_regions(facets, labels, one_sided, Adjacency.turn_at_border, settings.least_turn)
        labels = rectify(facets, labels, curvatures, costs)
        labels = facets.connected(~facets.sharp & ~facets.borders(labels))
        labels = merge_regions(facets, labels, curvatures, Adjacency.turn_of_means, settings.step_turn)
    planes = with_planes(facets, labels)
    if not np.array_equal(planes, labels):
        one_sided, _ = facets.curvature(facets.borders(planes))
        labels = merge_regions(facets, planes, one_sided, Adjacency.turn_at_border, settings.least_turn)
    labels = absorb(facets, labels, Adjacency.thickness, _THIN * facets.radius)
    labels = absorb(facets, labels, Adjacency.area_if_open, ball)
    return _without_hairs(facets, _without_folds(facets, labels))


def _without_folds(facets: Facets, labels: Labels) -> Labels:
    """Regions smaller than a ball that are folded over their neighbours all round go to one of these."""
    labels = renumbered(labels)
    border = facets.borders(labels)
    upright = labels[facets.edges.faces[border & (facets.edges.angle <= FOLDED)]]
    folded = np.bincount(labels, facets.areas) < np.pi * facets.radius**2
    folded[upright] = False

    def size(graph: Adjacency, region: int) -> float:
        return graph.area[region] if folded[region] else np.inf

    return absorb(facets, labels, size, np.inf, over_sharp=True)


def _without_hairs(facets: Facets, labels: Labels) -> Labels:
    least = min(_NOTHING * facets.radius, _HAIR * facets.diagonal)
    return absorb(facets, labels, Adjacency.thickness, least, over_sharp=True)


def _facets(points: Floats, triangles: Triangles, creases: Creases, radius: float | None) -> Facets:
    edges = mesh_edges(points, triangles)
    sharp = edges_among(edges.vertices, creases) & (edges.valence == 2)
    lengths = np.linalg.norm(np.diff(points[edges.vertices], axis=1)[:, 0], axis=1)
    return Facets(points, triangles, edges, sharp, radius or _SPACING * float(np.median(lengths)))


def _features(facets: Facets, labels: Labels) -> Flags:
    """Sharp edges that part regions, or that form networks of some length within one, (e,)."""
    between = facets.sharp & facets.borders(labels)
    within = np.flatnonzero(facets.sharp & ~between)
    ends = facets.edges.vertices[within]
    links = coo_array((np.ones(len(ends), np.int8), (ends[:, 0], ends[:, 1])), shape=(len(facets.points),) * 2)
    network = connected_components(links, directed=False)[1][ends[:, 0]]
    length = np.bincount(network, facets.lengths[within], minlength=1)
    between[within[length[network] >= _SHORTEST * facets.radius]] = True
    return between


def _on_target(triangles: Triangles, facets: Facets, changed: Flags, labels: Labels, features: Creases) -> Regions:
    """Carry regions and features back to the triangles as they were before needles were turned away."""
    if not changed.any():
        return Regions(labels, features)
    edges = mesh_edges(facets.points, triangles)
    own = replace(facets, triangles=triangles, edges=edges, sharp=edges_among(edges.vertices, features))
    carried = labels.copy()
    nearest = TriangleTree(facets.points, facets.triangles).closest(own.centres[changed])
    carried[changed] = labels[nearest.triangle]
    parts = own.connected(~own.borders(carried))
    carried = _without_hairs(own, _without_folds(own, parts))
    # A side of a needle that was flipped away lies along what it hid.
    flipped = ~edges_among(edges.vertices, facets.edges.vertices)
    along = flipped & np.isin(edges.vertices, features).all(axis=1)
    return Regions(carried, edges.vertices[own.sharp | (along & own.borders(carried))])

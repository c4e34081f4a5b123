"""The first control mesh of a whole part (Lavoué et al. 2007): segmented, its curves fitted, its patches joined."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.curves.network import bent_nodes, fit_network, sharp_vertices
from subdfit.errors import InputError
from subdfit.initial.lavoue_whole import PatchError, join_patches
from subdfit.mesh.checks import positive_length
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.features import automatic_creases, edges_among
from subdfit.target.network import Cuts, curve_network
from subdfit.target.segmentation import segment_mesh
from subdfit.target.segmentation_cutting import halved, part_cuts, without_handles
from subdfit.target.segmentation_noise import noise_of
from subdfit.target.segmentation_slivers import without_slivers
from subdfit.target.target import Target

Indices = NDArray[np.int64]

_MOST_CUTS = 20
"""Patches that are cut in two because their boundaries cannot be joined, before giving up."""


@dataclass(frozen=True)
class CutPart:
    """A part and where it is cut into patches that are disks with holes.

    Attributes
    ----------
    target : without needles; its creases are those along which it is cut.
    cuts : borders of its faces, creases, its boundary.
    noise : standard deviation of the target's points, 0 for none that matters.
    """

    target: Target
    cuts: Cuts
    noise: float = 0.0


def cut_part(target: Target) -> CutPart:
    """Segment a part and cut it into patches.

    Parameters
    ----------
    target : a mesh.

    Raises
    ------
    InputError
        The target is a point cloud.
    """
    if not target.is_mesh:
        raise InputError("a part is cut into patches of its faces, and points have none; reconstruct a mesh first")
    found = np.array_equal(target.crease_edges, automatic_creases(target.points, target.triangles))
    triangles, creases = without_slivers(target.points, target.triangles, target.crease_edges, found=found)
    target = replace(target, triangles=triangles, crease_edges=creases)
    regions = segment_mesh(target, find_creases=found)
    cuts = part_cuts(target.points, triangles, regions.labels, regions.feature_edges)
    cuts = without_handles(target.points, triangles, cuts)
    inner = cuts.exact & ~edges_among(cuts.edges, target.boundary_edges)
    noise = noise_of(target.points, triangles, creases)
    return CutPart(replace(target, crease_edges=cuts.edges[inner]), cuts, noise)


def whole_start(part: CutPart, tolerance: float) -> ControlMesh:
    """A quad-triangle control mesh of a part whose sharp control edges are its creases.

    Parameters
    ----------
    part : the part.
    tolerance : of the curves, in the target's unit.

    Raises
    ------
    InputError
        The tolerance is not positive.
    PatchError
        A patch has no control mesh, though it was cut in two many times.
    """
    tolerance = positive_length(tolerance, "the tolerance of the curves")
    points, triangles, cuts = part.target.points, part.target.triangles, part.cuts
    for tried in range(_MOST_CUTS + 1):
        turns = sharp_vertices(points, cuts.edges[cuts.exact])
        network = curve_network(triangles, cuts, turns)
        fitted = fit_network(points, network.arcs, tolerance)
        corners = np.flatnonzero(np.isin(fitted.nodes, np.union1d(turns, bent_nodes(points, network.arcs))))
        try:
            controls, limits, chains, places = fitted.points, fitted.limits, fitted.chains, fitted.places
            return join_patches(points, network, controls, limits, chains, places, corners, part.noise)
        except PatchError as error:
            if tried == _MOST_CUTS:
                raise
            cuts = halved(points, network.patches[error.patch], cuts)
    raise AssertionError

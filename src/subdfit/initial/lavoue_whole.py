"""A first control mesh of a whole part: the faces of all patches over the control points of a network of curves.

Lavoué, Dupont and Baskurt 2007, section 6, fit the patches of a segmented part one by one and join them along sharp
control edges. Here patches share the control points of the arcs between them, so that what joins them is watertight by
construction; an arc across which the surface is smooth has smooth control edges.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.initial.lavoue_fan import fan, ring_sides
from subdfit.initial.lavoue_patch import patch_faces
from subdfit.initial.lavoue_scores import ScoredSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.target.curvature import curvature_field, curvature_in_noise
from subdfit.target.network import Network, Patch

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Ring = list[int]


class PatchError(InputError):
    """A patch has no faces over its control points; `patch` is its number in the network."""

    def __init__(self, patch: int, why: str) -> None:
        super().__init__(f"patch {patch} of the part: {why}")
        self.patch = patch


def join_patches(
    points: Floats,
    network: Network,
    controls: Floats,
    limits: Floats,
    chains: Sequence[Indices],
    places: Sequence[Floats],
    corners: Indices,
    noise: float = 0.0,
) -> ControlMesh:
    """Control mesh whose vertices are the control points of a network's arcs.

    Parameters
    ----------
    points : (n, 3) float64, of the target.
    network : its arcs and patches, all of them disks with holes.
    controls, limits : (k, 3) float64, control points and their limits.
    chains, places : control points of each arc, and where they lie along it (see `ControlNetwork`).
    corners : control points that stay in place although no more than two sharp arcs meet there.
    noise : standard deviation of the target's points, 0 for none.

    Returns
    -------
    ControlMesh
        A vertex inside is added where no control edge cuts what is left of a patch.

    Raises
    ------
    PatchError
        A patch's boundaries cannot be joined; cut it in two.
    """
    along = [_pairs(arc.closed, chain) for arc, chain in zip(network.arcs, chains, strict=True)]
    creases = [pair for arc, pairs in zip(network.arcs, along, strict=True) if arc.sharp for pair in pairs]
    taken = {frozenset(pair) for pairs in along for pair in pairs}
    positions = list(controls)
    faces: list[Ring] = []
    for number, patch in enumerate(network.patches):
        try:
            found = patch_faces(_surface(points, patch, noise), patch.loops, chains, places, controls, limits, taken)
        except InputError as error:
            raise PatchError(number, str(error)) from error
        rings = list(found.faces)
        for ring in found.open:
            positions.append(limits[ring].mean(axis=0))
            rings += fan(ring, len(positions) - 1)
        taken |= {frozenset(side) for ring in rings for side in ring_sides(ring)}
        faces += rings
    faces = _without_thin(faces, positions)
    topology = Topology.from_faces(
        np.concatenate([[0], np.cumsum([len(ring) for ring in faces])]),
        np.concatenate(faces),
        len(positions),
        crease_edges=np.array(creases, np.int64).reshape(-1, 2),
        corner_vertices=corners,
    )
    return ControlMesh(topology, np.array(positions), "quad-triangle")


def _pairs(closed: bool, chain: Indices) -> list[tuple[int, int]]:
    """Control edges along an arc."""
    rows = chain.tolist()
    return list(pairwise([*rows, rows[0]] if closed else rows))


def _surface(points: Floats, patch: Patch, noise: float) -> ScoredSurface:
    own, faces = points[patch.origin], patch.triangles
    return ScoredSurface(own, faces, curvature_in_noise(own, faces, noise) if noise else curvature_field(own, faces))


def _without_thin(faces: list[Ring], positions: list[Floats]) -> list[Ring]:
    """Faces of which no inner vertex has two only: the larger of such two gets one more control edge, or a vertex.

    Changes both lists in place.
    """
    while True:
        owner: dict[int, list[int]] = {}
        for k, ring in enumerate(faces):
            for v in ring:
                owner.setdefault(v, []).append(k)
        sides = {side for ring in faces for side in ring_sides(ring)}
        rim = {v for side in sides if side[::-1] not in sides for v in side}
        thin = next((v for v, around in sorted(owner.items()) if len(around) == 2 and v not in rim), None)
        if thin is None:
            return faces
        k = max(owner[thin], key=lambda face: (len(faces[face]), -face))
        ring = faces.pop(k)
        at = ring.index(thin)
        turned = ring[at:] + ring[:at]
        across = [j for j in range(2, len(turned) - 1) if not {(thin, turned[j]), (turned[j], thin)} & sides]
        if across:
            middle = min(across, key=lambda j: abs(2 * j - len(turned)))
            faces += [turned[: middle + 1], [thin, *turned[middle:]]]
        else:
            positions.append(np.mean([positions[v] for v in ring], axis=0))
            faces += fan(turned, len(positions) - 1)

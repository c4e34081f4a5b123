"""Where tests look: parameters inside cells, along their sides and in their corners, for cells of both shapes."""

from functools import cache

import numpy as np

from shapes.kinds import cover
from shapes.zoo import mesh_of, shapes
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES
from subdfit.schemes._doo_sabin_curves import Curves
from subdfit.schemes.domain import TRIANGLE

CORNERS = {3: np.array([[0, 0], [1, 0], [0, 1.0]]), 4: np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])}

DUAL = ("doo-sabin", "doo-sabin-averaging")
"""Schemes whose vertices are face corners: a cell lies between a vertex, two edges and a face."""


@cache
def surface_of(scheme, name):
    """The limit surface of a shape of the zoo, compiled once."""
    return LimitSurface(mesh_of(name), scheme)


def takes(scheme, mesh):
    """Whether the scheme accepts the shape at all."""
    try:
        SCHEMES[scheme].validate(mesh.topology)
    except InputError:
        return False
    return True


CASES = [(scheme, name) for scheme in SCHEMES for name in shapes() if takes(scheme, mesh_of(name))]

SOME = [(scheme, name) for scheme in SCHEMES for name in cover([name for taker, name in CASES if taker == scheme])]
"""Few of them that have every kind of vertex, for what rests on the laws."""


def size(mesh):
    """Half the bounding box's diagonal, the length that errors are relative to."""
    return np.linalg.norm(np.ptp(mesh.points, axis=0)) / 2


def inside(domain, per_cell=5, margin=0.08, seed=0):
    """Random parameters in every cell, `margin` away from its sides: (face, uv)."""
    random = np.random.default_rng(seed)
    face = np.repeat(np.arange(domain.face_count), per_cell)
    weights = random.dirichlet([1, 1, 1], len(face)) * (1 - 3 * margin) + margin
    square = random.random((len(face), 2)) * (1 - 2 * margin) + margin
    return face, np.where((domain.shape[face] == TRIANGLE)[:, None], weights[:, 1:], square)


def anywhere(domain, per_cell=6, seed=0, nearest=17.0):
    """Random parameters in every cell, on its sides, near its corners (to 10^-nearest) and in them: (face, uv)."""
    random = np.random.default_rng(seed)
    face, uv = inside(domain, per_cell, 0.0, seed)
    faces, uvs = [face], [uv]
    for cell, shape in enumerate(domain.shape):
        corners = CORNERS[int(shape)]
        t = random.random((len(corners), 1))
        along = (1 - t) * corners + t * np.roll(corners, -1, axis=0)
        near = corners + 10.0 ** -random.uniform(0.5, nearest, (len(corners), 1)) * (corners.mean(axis=0) - corners)
        faces.append(np.full(3 * len(corners), cell))
        uvs += [along, near, corners]
    return np.concatenate(faces), np.concatenate(uvs)


def along_side(domain, face, side, t):
    """Parameters of the points at share `t` of the sides (face, side), in the direction round the cell."""
    uv = np.empty((len(face), 2))
    for k, (cell, i) in enumerate(zip(face, side, strict=True)):
        corners = CORNERS[int(domain.shape[cell])]
        uv[k] = (1 - t[k]) * corners[i] + t[k] * corners[(i + 1) % len(corners)]
    return uv


def sides(domain, sharp=None):
    """Sides with a cell beyond: (face, side, neighbour, side of the neighbour); `sharp` keeps one sort."""
    keep = domain.neighbour >= 0
    if sharp is not None:
        keep &= domain.sharp == sharp
    face, side = np.nonzero(keep)
    return face, side, domain.neighbour[face, side], domain.neighbour_side[face, side]


QUARTERS = {
    3: 0.5
    * np.array(
        [[[0, 0], [1, 0], [0, 1]], [[1, 0], [2, 0], [1, 1]], [[0, 1], [1, 1], [0, 2]], [[1, 1], [0, 1], [1, 0]]]
    ),
    4: 0.5
    * np.array(
        [
            [[0, 0], [1, 0], [1, 1], [0, 1]],
            [[2, 0], [2, 1], [1, 1], [1, 0]],
            [[2, 2], [1, 2], [1, 1], [2, 1]],
            [[0, 2], [0, 1], [1, 1], [1, 2]],
        ]
    ),
}
"""Children of a face that is a cell, in its parameters: one starts at each corner, a triangle's middle one is last."""


def parents(scheme, topology):
    """Where the cells of the refined mesh lie in those of the mesh: (cell (c,), corners (c, 4, 2), nan if none)."""
    domain = SCHEMES[scheme].domain(topology)
    if scheme in DUAL:
        return dual_parents(SCHEMES[scheme].refine(topology).child)
    if domain.face_count != topology.face_count:
        # The mesh's cells are the faces of the refined mesh already.
        return np.arange(domain.face_count), np.array([_padded(CORNERS[int(n)]) for n in domain.shape])
    cell = np.repeat(np.arange(domain.face_count), 4)
    padded = {n: np.array([_padded(quarter) for quarter in quarters]) for n, quarters in QUARTERS.items()}
    return cell, np.concatenate([padded[int(n)] for n in domain.shape])


def dual_parents(child):
    """The same for dual schemes: the cell of a face corner lies in the cell that its vertex is, at that face's corner.

    Round a cell's vertex the face that stands for a vertex comes first, which is the last in the numbering of faces. In
    its own cell a face corner's vertex, in the middle of the larger one, comes first.
    """
    before = np.empty_like(child.following)
    before[child.following] = np.arange(len(before))
    inner = face_corners(child)
    slot, first = np.zeros(len(before), int), np.zeros(child.vertex_count, int)
    np.maximum.at(first, child.face_vertices[inner], inner)
    corner = first[np.unique(child.face_vertices[inner])]
    for i in range(4):
        slot[corner] = i
        corner = child.twin[before[corner]]
    return child.face_vertices[inner], np.roll(QUARTERS[4], 2, axis=1)[slot[inner]]


def face_corners(topology):
    """The face corner (half-edge) of each cell of a dual scheme: all but those on curves that are plain."""
    return np.flatnonzero(Curves.of(topology).inner)


def _padded(corners):
    return np.vstack([corners, np.full((4 - len(corners), 2), np.nan)])


def child_of(scheme, topology, face, uv):
    """The cells of the refined mesh that hold parameters of the mesh.

    Returns
    -------
    face, uv : of the child; jacobian (k, 2, 2), derivative of the child's parameters by the parent's.
    """
    cell, corners = parents(scheme, topology)
    order, face, uv = np.argsort(cell, kind="stable"), np.asarray(face), np.asarray(uv, float)
    begin, count = np.searchsorted(cell[order], face), np.bincount(cell)[face]
    triangle = np.isnan(corners[:, 3, 0])
    last = np.where(triangle[:, None], corners[:, 2], corners[:, 3])
    inverse = np.linalg.inv(np.stack([corners[:, 1] - corners[:, 0], last - corners[:, 0]], axis=2))
    best = np.full(len(face), -np.inf)
    child, local = np.zeros(len(face), int), np.zeros((len(face), 2))
    for c in range(int(count.max())):
        tried = order[np.minimum(begin + c, len(order) - 1)]
        there = np.einsum("kij,kj->ki", inverse[tried], uv - corners[tried, 0])
        far = np.where(triangle[tried], 1 - there.sum(axis=1), 1 - there.max(axis=1))
        inner = np.where(c < count, np.minimum(there.min(axis=1), far), -np.inf)
        better = inner > best
        best[better], child[better], local[better] = inner[better], tried[better], there[better]
    return child, local, inverse[child]


def finer(scheme, name):
    """The surface of a shape refined twice, so that there is something out of reach."""
    surface = surface_of(scheme, name)
    mesh = surface.control_mesh
    for _ in range(2):
        step = surface.scheme.refine(mesh.topology)
        mesh = ControlMesh(step.child, step.refined(mesh.points), mesh.scheme)
    return LimitSurface(mesh, surface.scheme)

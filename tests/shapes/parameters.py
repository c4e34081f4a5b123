"""Where tests look: parameters inside cells, along their sides and in their corners, for cells of both shapes."""

from functools import cache

import numpy as np

from shapes.zoo import ZOO, mesh_of
from subdfit.errors import InputError
from subdfit.limit import LimitSurface
from subdfit.schemes import SCHEMES
from subdfit.schemes.domain import TRIANGLE

CORNERS = {3: np.array([[0, 0], [1, 0], [0, 1.0]]), 4: np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])}

CHILDREN = {
    "loop": 0.5
    * np.array([[[0, 0], [1, 0], [0, 1]], [[1, 0], [2, 0], [1, 1]], [[0, 1], [1, 1], [0, 2]], [[1, 1], [0, 1], [1, 0]]])
}
"""For schemes that cut a triangle in four: (children, corners, 2), the child's corners in its parent's parameters."""


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


CASES = [(scheme, name) for scheme in SCHEMES for name in ZOO if takes(scheme, mesh_of(name))]


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


def child_of(scheme, face, uv):
    """The child cells that hold the parameters after one step of refinement.

    Returns
    -------
    face, uv : of the child; jacobian (k, 2, 2), derivative of the child's parameters by the parent's.
    """
    corners = CHILDREN[scheme]
    inverse = np.linalg.inv(np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2))
    local = np.einsum("cij,ckj->cki", inverse, np.asarray(uv)[None] - corners[:, :1])
    inner = np.min(np.stack([local[..., 0], local[..., 1], 1 - local.sum(axis=2)]), axis=0)
    child = np.argmax(inner, axis=0)
    return len(corners) * np.asarray(face) + child, local[child, np.arange(len(child))], inverse[child]

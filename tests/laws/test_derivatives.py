"""Derivatives belong to positions: central differences, and the approach to corners."""

import numpy as np
import pytest

from shapes.parameters import CORNERS, inside, size
from shapes.sectors import corners_of

STEP = np.array([[[1, 0], [-1, 0]], [[0, 1], [0, -1.0]]])


def difference(surface, face, uv, h, what):
    """Central differences of `what` (position or first) by u and by v."""
    moved = uv[None, None] + h * STEP[:, :, None]
    values = [[getattr(surface.evaluate(face, side, 1), what) for side in pair] for pair in moved]
    return [(ahead - behind) / (2 * h) for ahead, behind in values]


def test_first_derivatives_against_differences(surface):
    face, uv = inside(surface.domain)
    first = surface.evaluate(face, uv, 1).first
    for d, by in enumerate(difference(surface, face, uv, 1e-5, "position")):
        assert np.abs(first[:, d] - by).max() < 2e-8 * size(surface.control_mesh)


def test_second_derivatives_against_differences_of_the_first(surface):
    face, uv = inside(surface.domain)
    second = surface.evaluate(face, uv, 2).second
    by_u, by_v = difference(surface, face, uv, 1e-5, "first")
    for value, by in [(second[:, 0], by_u[:, 0]), (second[:, 1], by_u[:, 1]), (second[:, 2], by_v[:, 1])]:
        assert np.abs(value - by).max() < 1e-5 * size(surface.control_mesh)
    assert np.abs(by_u[:, 1] - by_v[:, 0]).max() < 1e-5 * size(surface.control_mesh)


@pytest.mark.parametrize("direction", [0.0, 0.25, 1.0])
def test_positions_converge_to_the_corner_without_turning_back(surface, direction):
    """Along rays into a corner, at 2^-k: finite everywhere, the distance falls until it is rounding.

    The rays' directions are such that parameters beside 1 are exact for as long as they differ from 1.
    """
    domain = surface.domain
    powers = 2.0 ** -np.arange(3, 61)
    noise = 4e-16 * 10 * size(surface.control_mesh)
    for shape, i in [(3, 0), (3, 1), (3, 2), (4, 0), (4, 1), (4, 2), (4, 3)]:
        face = np.flatnonzero(domain.shape == shape)
        if len(face) == 0:
            continue
        corner, a, b = CORNERS[shape][i], CORNERS[shape][(i + 1) % shape], CORNERS[shape][i - 1]
        ray = (1 - direction) * a + direction * b - corner
        uv = np.tile(corner + powers[:, None] * ray, (len(face), 1))
        value = surface.evaluate(np.repeat(face, len(powers)), uv, 2)
        assert all(np.isfinite(array).all() for array in value)
        limit = surface.evaluate(face, np.tile(corner, (len(face), 1))).position
        distance = np.linalg.norm(value.position.reshape(len(face), -1, 3) - limit[:, None], axis=2)
        assert (distance[:, -1:] < 1e-8 * size(surface.control_mesh)).all()
        assert (distance[:, 1:] <= distance[:, :-1] + noise).all()


def test_derivatives_in_the_corners_are_of_the_size_of_the_mesh(surface):
    """Where derivatives vanish or diverge, limit tangents stand in, scaled as at a regular corner."""
    domain = surface.domain
    face, corner = np.nonzero(domain.vertex >= 0)
    uv = np.array([CORNERS[int(domain.shape[f])][c] for f, c in zip(face, corner, strict=True)])
    for derivative in (1, 2):
        rows = surface.weights(face, uv, derivative)
        assert np.abs(rows).sum(axis=1).max() < 12
    assert np.abs(surface.evaluate(face, uv, 1).first).max() < 12 * size(surface.control_mesh)


def test_curves_along_sharp_sides_keep_their_tangent_into_the_corner(surface):
    """Boundary and crease curves are cubic splines whatever meets them.

    Left out are darts, and untagged corners of one cell: there the curve passes both sides of the cell in one
    direction, and limit tangents must span the cell's plane.
    """
    domain, corners = surface.domain, corners_of(surface)
    tagged = corners.pinned | (corners.sharp_sides >= 3)
    for turn in (1, -1):
        number = np.array([len(CORNERS[int(domain.shape[f])]) for f in corners.face])
        here = np.array(
            [np.abs(CORNERS[n] - uv).sum(axis=1).argmin() for n, uv in zip(number, corners.uv, strict=True)]
        )
        side = np.where(turn == 1, here, (here - 1) % number)
        keep = domain.sharp[corners.face, side] & (tagged | ((corners.cells > 1) & (corners.sharp_sides == 2)))
        face, uv = corners.face[keep], corners.uv[keep]
        ends = [CORNERS[n][(k + turn) % n] for n, k in zip(number[keep], here[keep], strict=True)]
        step = np.reshape(ends, (-1, 2)) - uv
        curve = [np.einsum("kd,kdx->kx", step, surface.evaluate(face, uv + t * step, 1).first) for t in (0.0, 2.0**-30)]
        at, near = (tangent / np.linalg.norm(tangent, axis=1, keepdims=True) for tangent in curve)
        assert np.abs(at - near).max(initial=0) < 1e-6

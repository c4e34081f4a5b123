"""The surface hangs together: positions across every side, tangent planes across smooth ones and round vertices."""

import numpy as np
import pytest

from shapes.parameters import CORNERS, DUAL, along_side, sides, size
from shapes.sectors import corners_of

FLAT_SECTORS = {
    "loop": (5, 2),
    "catmull-clark": (3, 1),
    **dict.fromkeys(DUAL, (99, 1)),
    "quad-triangle": (3, 1),
}
"""Most cells in a sector between two sharp edges for which a tangent plane exists: at a crease vertex, at a corner.

For Loop the subdominant eigenvalues of a crease vertex are 1/2 (along) and 3/8 + cos(pi/k)/4 (across) up to k = 5; at
k = 6 the next one reaches 1/2. A corner's two sharp edges (1/2) are subdominant up to k = 2. For Catmull-Clark the next
eigenvalue of a crease vertex is .410 at k = 3 and reaches 1/2 at k = 4, that of a corner at k = 2.
"""

SLOW_SECTORS = {"loop": (5,), "catmull-clark": (1, 3), **dict.fromkeys(DUAL, ()), "quad-triangle": (1, 3)}
"""Cells in sectors at crease vertices in which normals converge too slowly to be tested by a distance.

For Loop .488 / .5 a level; for Catmull-Clark .410 / .5, and like 1 / level in a single cell (a Jordan block of 1/4).
"""


def pairs(surface, sharp, count=9):
    """Points on sides seen from both cells: (face, uv, neighbour, uv there)."""
    face, side, beyond, other = (np.repeat(array, count) for array in sides(surface.domain, sharp))
    t = np.tile(np.linspace(0.03, 0.96, count), len(face) // count)
    here = along_side(surface.domain, face, side, t)
    return face, here, beyond, along_side(surface.domain, beyond, other, 1 - t)


def normals(first):
    normal = np.cross(first[:, 0], first[:, 1])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_neighbours_know_each_other_and_agree_on_sharpness(surface):
    domain = surface.domain
    face, side, beyond, other = sides(domain)
    np.testing.assert_array_equal(domain.neighbour[beyond, other], face)
    np.testing.assert_array_equal(domain.neighbour_side[beyond, other], side)
    np.testing.assert_array_equal(domain.sharp[face, side], domain.sharp[beyond, other])
    for cell, shape in enumerate(domain.shape):
        boundary = domain.neighbour[cell, :shape] < 0
        assert domain.sharp[cell, :shape][boundary].all()


def test_positions_agree_across_every_side(surface):
    for sharp in (False, True):
        face, uv, beyond, there = pairs(surface, sharp)
        gap = surface.evaluate(face, uv).position - surface.evaluate(beyond, there).position
        assert np.abs(gap).max(initial=0) < 1e-14 * 10 * size(surface.control_mesh)


def test_tangent_planes_agree_across_every_smooth_side(surface):
    face, uv, beyond, there = pairs(surface, False)
    if len(face) == 0:
        return
    normal = normals(surface.evaluate(face, uv, 1).first)
    first = surface.evaluate(beyond, there, 1).first
    first /= np.linalg.norm(first, axis=2, keepdims=True)
    assert np.abs(np.einsum("kdx,kx->kd", first, normal)).max() < 1e-11
    assert (np.einsum("kx,kx->k", normal, normals(first)) > 0).all()


def test_curves_along_sharp_sides_have_one_tangent_seen_from_both_cells(surface):
    face, side, beyond, other = sides(surface.domain, True)
    for t in (0.2, 0.7):
        ends = []
        for cells, edge, share, sign in [(face, side, t, 1), (beyond, other, 1 - t, -1)]:
            uv = along_side(surface.domain, cells, edge, np.full(len(cells), share))
            step = along_side(surface.domain, cells, edge, np.ones(len(cells)))
            step -= along_side(surface.domain, cells, edge, np.zeros(len(cells)))
            ends.append(sign * np.einsum("kd,kdx->kx", step, surface.evaluate(cells, uv, 1).first))
        assert np.abs(ends[0] - ends[1]).max(initial=0) < 1e-12 * size(surface.control_mesh)


def flat(corners, scheme):
    """Corners whose sector has a tangent plane: not round inner vertices of valence two."""
    crease, corner = FLAT_SECTORS[scheme]
    bounded = corners.sharp_sides >= 2
    tagged = corners.pinned | (corners.sharp_sides >= 3)
    return np.where(bounded, corners.cells <= np.where(tagged, corner, crease), ~tagged & (corners.cells > 2))


def test_normals_agree_round_every_vertex_with_a_tangent_plane(surface):
    corners = corners_of(surface)
    keep = flat(corners, surface.scheme.name)
    normal = np.zeros((len(keep), 3))
    normal[keep] = surface.normals(corners.face[keep], corners.uv[keep])
    assert np.linalg.norm(normal[keep], axis=1) == pytest.approx(1)
    for sector in np.unique(corners.sector[keep]):
        group = normal[corners.sector == sector]
        assert np.abs(group - group[0]).max() < 1e-11


def test_normals_in_the_corners_are_limits_of_normals_inside(surface):
    """They are approached by the third eigenvalue over those of the tangents, to a fixed share a level.

    Of the sectors kept a dart of eight quads is slowest, with 1/2 (the smooth vertex's frequency 2, which vanishes on
    the sharp edge) over .5819 and .6111: r = .8592 and s = .8182 a level. Where r^k and s^k start equal and opposite,
    their difference falls from level 24 to 36 by r^12 (1 - (s/r)^36) / (1 - (s/r)^24), 1.2 times r^12.
    """
    corners = corners_of(surface)
    keep = flat(corners, surface.scheme.name) & (corners.cells <= 8)
    slow = np.isin(corners.cells, SLOW_SECTORS[surface.scheme.name]) & ~corners.pinned
    keep &= (corners.sharp_sides != 2) | ~slow
    face, uv = corners.face[keep], corners.uv[keep]
    middle = np.reshape([CORNERS[int(surface.domain.shape[f])].mean(axis=0) for f in face], (-1, 2))
    at = surface.normals(face, uv)
    far, near = (
        np.abs(surface.normals(face, uv + 2.0**-level * (middle - uv)) - at).max(initial=0) for level in (24, 36)
    )
    assert near < 0.01
    # Rounding counts 2^36 times.
    assert near <= 1.2 * 0.8592**12 * far + 1e-5

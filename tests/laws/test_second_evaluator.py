"""Refinement alone, cut out ever smaller round a point, leads to the surface that patches give."""

import numpy as np
import pytest

from shapes.parameters import CASES, DUAL, anywhere, size, surface_of
from shapes.zoom import can_be_cut_out, zoom


@pytest.mark.parametrize(("scheme", "name"), [case for case in CASES if can_be_cut_out(*case)])
def test_a_second_evaluator_without_patches_agrees(scheme, name):
    """At one point or two of each shape: zooming in is slow, slowest with dual schemes, whose parts are larger."""
    surface = surface_of(scheme, name)
    face, uv = anywhere(surface.domain, per_cell=1, seed=2, nearest=3.0)
    chosen = np.random.default_rng(3).permutation(len(face))[: 1 if scheme in DUAL else 2]
    expected = [zoom(scheme, surface.control_mesh, face[k], uv[k]) for k in chosen]
    value = surface.evaluate(face[chosen], uv[chosen]).position
    assert np.abs(value - expected).max() < 1e-12 * size(surface.control_mesh)

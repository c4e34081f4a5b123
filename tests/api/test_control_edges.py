"""The curves that draw a control mesh on its surface: one an edge, from limit point to limit point."""

import numpy as np
import pytest

from shapes.parameters import surface_of
from subdfit.api.pictures import control_edges

SEGMENTS = 4


@pytest.mark.parametrize(
    ("scheme", "name"),
    [("loop", "crowded"), ("catmull-clark", "prism 4"), ("catmull-clark", "house"), ("doo-sabin", "prism 5")],
)
def test_every_edge_is_drawn_once(scheme, name):
    surface = surface_of(scheme, name)
    t = surface.topology
    found = control_edges(surface, SEGMENTS)
    halves = 2 if surface.domain.parts else 1
    assert found.shape == (halves * SEGMENTS * t.edge_count, 2, 3)
    limits = surface.vertex_limits()
    ends = found.reshape(-1, SEGMENTS, 2, 3)[:, [0, -1], [0, 1]].reshape(-1, 3)
    gap = np.linalg.norm(ends[:, None] - limits, axis=2)
    assert ((gap < 1e-12).sum(axis=0) == np.bincount(t.edge_vertices.ravel())).all()

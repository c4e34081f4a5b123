"""The remedy that the line of a fit suggests: one that applies, and helps where that can be tried."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from tests.shapes.zoo import octahedron_data, pyramid_data

import subdfit
from subdfit.api.remedies import remedy
from subdfit.cli.summary import fit_line, picture_title, verdict_on


@pytest.fixture(scope="module")
def spent(sphere):
    return subdfit.fit(sphere, max_error="0.001%", control_vertices=20, max_control_vertices=30)


def turned(result, status):
    """The result, had a tenth of its surface faced the wrong way."""
    return replace(result, status=status, certified=False, measurement=replace(result.measurement, facing_away=0.1))


@pytest.mark.parametrize("part", [octahedron_data(), pyramid_data(4)])
def test_sharp_edges_of_small_parts_are_creases(part):
    found = subdfit.fit(part)
    assert found.status == "best_effort"
    assert "--creases 30" in remedy(found)
    creased = subdfit.fit(part, creases=30)
    assert creased.certified
    assert remedy(creased) is None


def test_a_budget_that_is_spent(spent):
    assert remedy(spent) == "the budget of 30 control vertices is spent: allow more (--max-control-vertices)"
    assert fit_line(spent).endswith(" s; " + remedy(spent))
    everything = replace(spent, target=replace(spent.target, used=spent.target.used[:30]))
    assert remedy(replace(everything, measurement=replace(spent.measurement, footpoints=first(spent, 30)))) == (
        "30 data points allow no more control vertices: ask for a larger error or give more data"
    )


def first(result, count):
    """The footpoints of the first data points."""
    return replace(result.measurement.footpoints, distance=result.measurement.footpoints.distance[:count])


def test_short_boundary_loops_may_be_holes(sphere):
    points, triangles = sphere
    kept, left = [], set(range(len(points)))
    for triangle in triangles.tolist():  # every hole is one triangle, and no two holes meet
        if left.issuperset(triangle) and len(left) > len(points) - 60:
            left -= set(triangle)
        else:
            kept.append(triangle)
    found = subdfit.fit((points, np.array(kept)), max_error="0.00001%", max_control_vertices=len(points))
    assert found.status == "best_effort"
    assert remedy(found) == "if the 20 short boundary loops are holes: --fill-holes 30"


@pytest.mark.parametrize(
    ("status", "verdict"),
    [
        ("within_tolerance", "not certified, part of the surface faces the wrong way"),
        ("best_effort", "tolerance not reached"),
    ],
)
def test_a_surface_that_faces_the_wrong_way(spent, status, verdict):
    found = turned(spent, status)
    assert verdict_on(found) == verdict
    assert "ask for a smaller error" in remedy(found)
    assert "faces the wrong way" in fit_line(found)
    assert remedy(found) not in picture_title(found)


def test_what_was_interrupted_needs_no_remedy(spent):
    assert remedy(replace(spent, status="interrupted")) is None


@pytest.mark.parametrize(("ask", "told"), [("0.1%", True), ("3%", False)])
def test_a_certificate_that_coarse_facets_weaken_says_so(ask, told):
    sphere = trimesh.creation.icosphere(2)
    found = subdfit.fit((sphere.vertices, sphere.faces), max_error=ask)
    assert found.certified
    assert told == (found.measurement.reverse_max > 2 * found.settings.tolerance.max)
    assert told == (remedy(found) is not None)
    assert not told or "give a finer mesh" in fit_line(found)

"""The memory of fits: estimated before they begin, and not exceeded."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import subdfit
from subdfit.api.memory import estimate, vertices_within
from subdfit.errors import InputError
from subdfit.parallel import threads
from subdfit.schemes import SCHEMES


def allowing(vertices):
    """Memory for so many control vertices of a fit to the fixture `sphere`."""
    return estimate(642, 3840, vertices, threads=threads())


FIT = """
import json, sys
import numpy as np
from scipy.spatial import ConvexHull
import subdfit

def sphere(count):
    z = 1 - (2 * np.arange(count) + 1) / count
    turn, radius = np.pi * (1 + 5**0.5) * np.arange(count), np.sqrt(1 - z**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), z])

def stop(step):
    history.append(step.control_vertices)
    if len(history) > 2:
        raise KeyboardInterrupt

history, asked = [], json.loads(sys.argv[1])
points = sphere(asked.pop("points"))
triangles = ConvexHull(points).simplices if asked.pop("mesh") else None
subdfit.fit(points if triangles is None else (points, triangles), progress=stop, threads=2, **asked)
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(json.dumps([max(history), 1024 * int(peak)]))
"""
"""A few rounds of a fit, then its certificate; prints the most control vertices and the process's peak in bytes."""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak is read where Linux tells it")
@pytest.mark.parametrize(
    ("mesh", "points", "vertices", "options"),
    [
        (True, 20_000, 10_000, {"scheme": "loop"}),
        (True, 12_000, 6_000, {"scheme": "catmull-clark"}),
        (True, 12_000, 6_000, {"scheme": "doo-sabin", "method": "geometric"}),
        (True, 12_000, 6_000, {"scheme": "quad-triangle"}),
        (False, 6_000, 3_000, {"scheme": "loop"}),
    ],
)
def test_a_fit_keeps_within_the_estimate_which_is_not_far_above(mesh, points, vertices, options):
    """In a process of its own, kernels compiled or not."""
    limit = estimate(points, 6 * points, vertices, options["scheme"], threads=2)
    asked = {"mesh": mesh, "points": points, "max_error": 1e-9, "control_vertices": vertices, "memory": limit}
    call = [sys.executable, "-W", "ignore", "-c", FIT, json.dumps(asked | options)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run(call, capture_output=True, text=True, check=True, env=environment)
    most, peak = json.loads(done.stdout)
    assert vertices <= most <= 1.001 * vertices
    assert peak <= limit <= 3 * peak


@pytest.mark.parametrize(
    ("points", "faces", "vertices", "peak"),
    [
        (35_947, 69_451, 4_348, 386),
        (134_345, 268_686, 7_029, 419),
        (134_345, 268_686, 107_693, 1769),
        (437_645, 871_414, 2_000, 811),
    ],
)
def test_the_estimate_is_at_most_twice_the_measured_peak(points, faces, vertices, peak):
    """Peaks in MiB, as measured on bunny, igea and dragon with Loop and two threads."""
    assert 1.0 <= estimate(points, 3 * faces, vertices, threads=2) / (peak << 20) <= 2.0


def test_the_budget_is_lowered_to_what_the_memory_allows(sphere, caplog):
    limit = allowing(60)
    result = subdfit.fit(sphere, max_error="0.0001%", memory=limit)
    assert "mesh: " in caplog.text
    assert "of memory allow 60 control vertices, and the fit takes no more" in caplog.text
    assert result.status == "best_effort"
    assert result.settings.max_control_vertices == 60
    assert 30 < max(row.control_vertices for row in result.history) <= 60


@pytest.mark.parametrize("scheme", SCHEMES)
def test_all_schemes_have_an_estimate_that_grows_with_control_vertices(scheme):
    few, many = (estimate(1000, 6000, vertices, scheme) for vertices in (100, 200))
    assert many - few >= 100 * 15000
    assert vertices_within(many, 1000, 6000, scheme) <= 200


def test_a_budget_that_the_memory_allows_stays_and_nothing_is_told(sphere, caplog):
    result = subdfit.fit(sphere, max_error="1%", max_control_vertices=50, memory=allowing(60))
    assert result.settings.max_control_vertices == 50
    assert "of memory allow" not in caplog.text


def test_a_start_that_the_memory_does_not_allow_is_refused(sphere):
    with pytest.raises(InputError, match=r"mesh: a job with 642 points and 500 control vertices needs about \d+M"):
        subdfit.fit(sphere, control_vertices=500, memory=allowing(60))


def test_measuring_a_control_mesh_that_the_memory_does_not_allow_is_refused(sphere):
    cage = subdfit.fit(sphere, max_error="1%", control_vertices=100).control_mesh
    with pytest.raises(InputError, match=r"642 points and 100 control vertices needs about .* or fewer control"):
        subdfit.measure(cage, sphere, memory=allowing(50))


def test_a_cloud_is_taken_to_have_the_triangles_that_join_it():
    assert estimate(1000, 0) == estimate(1000, 6000)

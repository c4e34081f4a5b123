"""Catmull-Clark's limit points equal those of Blender's subdivision surface, which evaluates with OpenSubdiv.

Without Blender a sample that was stored is compared. ``make test-external`` installs Blender as a Python module and
compares every point, and the sample with what it now gives; ``python -m external.store`` there writes the sample anew.
"""

import os

import numpy as np
import pytest

from external.blender import STORED, VERSION, ask
from external.cases import CASES, our_limits, rows_of, tagged

EXACT = 1e-6
DARTS = 3e-6
"""Bounds as shares of the diagonal. At darts Blender puts the smooth limit mask at its last level of isolation: its
error halves with every level of quality, and is 2.2e-6 at the tenth (see `test_at_darts_blender_converges_to_us`)."""


def darts(t):
    """Vertices at the end of one crease that is sharp for ever."""
    ends = t.edge_vertices[np.isinf(t.sharpness)]
    return (np.bincount(ends.ravel(), minlength=t.vertex_count) == 1) & ~np.isinf(t.corner_sharpness)


def distances(cage, rows, theirs):
    """Distances of our points from theirs, as shares of the diagonal, and their bounds."""
    t, diagonal = cage.mesh.topology, np.linalg.norm(np.ptp(cage.mesh.points, axis=0))
    bound = np.full(t.vertex_count + t.edge_count + t.face_count, EXACT)
    bound[: t.vertex_count][darts(t)] = DARTS
    return np.linalg.norm(our_limits(cage.mesh)[rows] - theirs, axis=1) / diagonal, bound[rows]


@pytest.mark.parametrize("name", CASES)
def test_limits_equal_the_stored_ones_of_blender(meshes, name):
    with np.load(STORED) as stored:
        assert str(stored["version"]) == VERSION
        rows, theirs = stored[f"{name}/rows"], stored[f"{name}/limits"]
    assert len(rows) >= 100
    distance, bound = distances(tagged(CASES[name], meshes), rows, theirs)
    assert (distance < bound).all()


@pytest.fixture(scope="module")
def blender(meshes):
    """Every case as Blender evaluates it now."""
    if "SUBDFIT_BLENDER" not in os.environ:
        pytest.skip("make test-external compares with Blender itself")
    cages = {name: tagged(case, meshes) for name, case in CASES.items()}
    return cages, ask(cages)


@pytest.mark.parametrize("name", CASES)
def test_limits_equal_blenders(blender, name):
    cages, found = blender
    cage = cages[name]
    rows = rows_of(cage.mesh.topology, found[f"{name}/edges"])
    distance, bound = distances(cage, rows, found[f"{name}/limits"])
    assert (distance < bound).all()
    with np.load(STORED) as stored:
        place = np.empty_like(rows)
        place[rows] = np.arange(len(rows))
        again = found[f"{name}/limits"][place[stored[f"{name}/rows"]]]
        np.testing.assert_allclose(stored[f"{name}/limits"], again, atol=1e-6 * np.ptp(cage.mesh.points))


def test_at_darts_blender_converges_to_us(blender):
    """Half the error a level: from the sixth level of quality to the ninth about an eighth."""
    cages, _ = blender
    cages = {name: cages[name] for name in ("suzanne sharp", "fandisk_quads sharp")}
    for name, cage in cages.items():
        worst = []
        for quality in (6, 9):
            found = ask({name: cage}, quality)
            rows = rows_of(cage.mesh.topology, found[f"{name}/edges"])
            distance, bound = distances(cage, rows, found[f"{name}/limits"])
            worst.append(distance[bound == DARTS].max())
        assert worst[0] > 4 * worst[1]

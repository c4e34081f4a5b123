"""Laws of keeping components: sizes, rows and order."""

import initial_laws as laws
import numpy as np
import pytest

from subdfit.errors import InputError
from subdfit.initial import keep_components


def three_pieces():
    """A small sphere, an unused point, a large torus and a middling square."""
    (p, t), (q, s), (r, u) = laws.sphere(1), laws.torus(12, 8), laws.square(5)
    points = np.concatenate([0.1 * p, [[9.0, 9.0, 9.0]], q + 3, r - 3])
    return points, np.concatenate([t, s + len(p) + 1, u + len(p) + 1 + len(q)])


@pytest.mark.parametrize(("count", "sizes"), [(1, (96,)), (2, (96, 25)), (3, (18, 96, 25)), (9, (18, 96, 25))])
def test_largest_by_area_stay_in_the_order_of_the_input(count, sizes):
    points, triangles = three_pieces()
    kept = keep_components(points, triangles, count)
    assert kept.component_count == 3
    assert len(kept.points) == sum(sizes)
    assert laws.shape_of(len(kept.points), kept.triangles).components == len(sizes)
    np.testing.assert_array_equal(kept.points, points[kept.point_rows])
    np.testing.assert_array_equal(kept.point_rows[kept.triangles], triangles[kept.triangle_rows])
    assert (np.diff(kept.point_rows) > 0).all()
    assert (np.diff(kept.triangle_rows) > 0).all()


def test_of_equal_pieces_the_first_stays():
    points, triangles = laws.tetrahedron()
    shifted = triangles + 4
    kept = keep_components(np.concatenate([points, points]), np.concatenate([shifted, triangles]), 1)
    np.testing.assert_array_equal(kept.point_rows, [4, 5, 6, 7])


def test_dragon_has_its_151_components(meshes):
    kept = keep_components(*laws.read(meshes, "dragon"), 1)
    assert kept.component_count == 151
    assert len(kept.points) == 436846


def test_bad_input_is_refused():
    points, triangles = laws.tetrahedron()
    with pytest.raises(InputError, match="count"):
        keep_components(points, triangles, 0)
    with pytest.raises(InputError, match="names a point"):
        keep_components(points[:3], triangles, 1)

"""The Delaunay tetrahedralisation of a cloud, with the smallest empty sphere of each facet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from subdfit.initial._delaunay_kernels import facet_radii
from subdfit.parallel import map_chunks

Floats = NDArray[np.float64]

FAR = 2.0
"""Distance of the four outer points from the centre: their tetrahedron contains a ball of radius 2/3."""

NEIGHBOURS = 6
"""The spacing at a point is the distance to this nearest neighbour: where the sampling is regular, the first ring."""

CELLS_A_CHUNK = 1 << 14


@dataclass(frozen=True, eq=False)
class Tetrahedra:
    """Tetrahedra between n given and four far points, so that no given point is on the hull.

    Attributes
    ----------
    points : (n + 4, 3) float64.
    cells : (c, 4) int32, rows of `points`.
    beyond : (c, 4) int32, the cell across the facet opposite each corner, -1 outside the hull.
    radii : (4 c,) float64, of the smallest empty sphere through facet ``4 cell + corner``; infinite for facets that
        touch a far point, have no area, or whose radius exceeds what is allowed at each corner.
    """

    points: Floats
    cells: NDArray[np.int32]
    beyond: NDArray[np.int32]
    radii: Floats


def tetrahedra(points: Floats, largest: Floats) -> Tetrahedra:
    """Tetrahedralise points in the normalised frame, (n, 3), no two the same; `largest`, (n,), bounds radii at each.

    Without the far points a flat cloud has no tetrahedra, and the hull's facets only one side. Qhull leaves cells
    without volume between points on one sphere; their neighbours agree, so that turning round an edge passes them.
    """
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    found = Delaunay(np.concatenate([points, FAR / np.sqrt(3) * corners]), qhull_options="Qbb Qc Q12")
    cells, beyond = np.ascontiguousarray(found.simplices), np.ascontiguousarray(found.neighbors)
    radii = np.full(cells.size, np.inf)
    map_chunks(
        lambda start, stop: facet_radii(found.points, cells, beyond, largest, start, stop, radii),
        len(cells),
        CELLS_A_CHUNK,
    )
    return Tetrahedra(found.points, cells, beyond, radii)


def spacing(points: Floats) -> Floats:
    """Distance of each of (n, 3) points from its sixth nearest neighbour, or from the last there is, (n,)."""
    count = min(NEIGHBOURS + 1, len(points))
    distance, _ = cKDTree(points).query(points, [count])
    return np.asarray(distance, np.float64).ravel()

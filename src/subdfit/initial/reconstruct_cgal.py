"""The greedy reconstruction of the CGAL library, an extra: a second engine, and a check on our own."""

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh._polygons import Polygons, edges_of
from subdfit.mesh._sheets import orientation


def cgal_triangles(points: NDArray[np.float64], gap: float) -> NDArray[np.int64]:
    """Choose triangles among distinct points (n, 3) as `greedy_triangles` does; `gap` is not known to CGAL.

    Raises
    ------
    InputError
        CGAL is not installed.
    """
    try:
        from CGAL.CGAL_Advancing_front_surface_reconstruction import advancing_front_surface_reconstruction
        from CGAL.CGAL_Kernel import Point_3
        from CGAL.CGAL_Point_set_3 import Point_set_3
    except ImportError:
        raise InputError("method cgal needs the CGAL library; install it: pip install 'subdfit[cgal]'") from None
    cloud = Point_set_3()
    for point in points.tolist():
        cloud.insert(Point_3(*point))
    corners: list[int] = []
    advancing_front_surface_reconstruction(cloud, corners)
    triangles = np.array(corners, np.int64).reshape(-1, 3)
    faces = Polygons(3 * np.arange(len(triangles) + 1), triangles.ravel())
    turned, _ = orientation(faces, edges_of(faces))
    return np.where(turned[:, None], triangles[:, ::-1], triangles)

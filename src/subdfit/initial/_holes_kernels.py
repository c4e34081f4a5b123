"""The triangulation of one hole's rim that bends least, by dynamic programming."""

import numpy as np

from subdfit.compiled import inner_kernel, kernel


@inner_kernel
def _normal(points, i, j, k):  # type: ignore[no-untyped-def]
    """Twice the area vector of triangle (i, j, k)."""
    a0, a1, a2 = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    b0, b1, b2 = points[k, 0] - points[i, 0], points[k, 1] - points[i, 1], points[k, 2] - points[i, 2]
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@inner_kernel
def _bend(a0, a1, a2, b0, b1, b2):  # type: ignore[no-untyped-def]
    """1 - cosine of the angle between two normals, 0 where one has no direction."""
    lengths = np.sqrt((a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1 + b2 * b2))
    return 1.0 - (a0 * b0 + a1 * b1 + a2 * b2) / lengths if lengths > 0.0 else 0.0


@kernel
def triangulate_rim(rim, behind, taken):  # type: ignore[no-untyped-def]
    """Triangulate a closed polygon in space: least worst dihedral angle first, then least area.

    Liepa, Filling holes in meshes, 2003, section 3 (after Barequet and Sharir 1995): the best fill of the
    rim from i to k is the best choice of a triangle (i, j, k) over the best fills of i..j and j..k.

    Parameters
    ----------
    rim : (n, 3) float64, the corners in the order in which the fill's triangles run round.
    behind : (n, 3) float64, normals of the mesh's triangles beyond the edges (i, i + 1).
    taken : (n, n) bool, pairs that the mesh joins already: no chord may join them again.

    Returns
    -------
    triangles : (n - 2, 3) int64, corners of the rim.
    found : bool, False where every triangulation uses a taken pair.
    """
    n = len(rim)
    bend = np.zeros((n, n))
    area = np.zeros((n, n))
    split = np.full((n, n), -1, np.int32)
    for span in range(2, n):
        for i in range(n - span):
            k = i + span
            bend[i, k] = np.inf
            closing = i == 0 and k == n - 1
            if taken[i, k] and not closing:
                continue
            for j in range(i + 1, k):
                if bend[i, j] == np.inf or bend[j, k] == np.inf:
                    continue
                x, y, z = _normal(rim, i, j, k)
                worst = max(bend[i, j], bend[j, k])
                for low, high in ((i, j), (j, k)):
                    if high == low + 1:
                        p, q, r = behind[low, 0], behind[low, 1], behind[low, 2]
                    else:
                        p, q, r = _normal(rim, low, np.int64(split[low, high]), high)
                    worst = max(worst, _bend(x, y, z, p, q, r))
                if closing:
                    worst = max(worst, _bend(x, y, z, behind[k, 0], behind[k, 1], behind[k, 2]))
                total = area[i, j] + area[j, k] + 0.5 * np.sqrt(x * x + y * y + z * z)
                if worst < bend[i, k] or (worst == bend[i, k] and total < area[i, k]):
                    bend[i, k], area[i, k], split[i, k] = worst, total, j

    triangles = np.empty((n - 2, 3), np.int64)
    found = bend[0, n - 1] < np.inf
    stack = np.empty((n, 2), np.int64)
    stack[0, 0], stack[0, 1] = 0, n - 1
    depth = 1 if found else 0
    count = 0
    while depth > 0:
        depth -= 1
        i, k = stack[depth, 0], stack[depth, 1]
        if k - i >= 2:
            j = split[i, k]
            triangles[count, 0], triangles[count, 1], triangles[count, 2] = i, j, k
            count += 1
            stack[depth, 0], stack[depth, 1] = i, j
            stack[depth + 1, 0], stack[depth + 1, 1] = j, k
            depth += 2
    return triangles, found

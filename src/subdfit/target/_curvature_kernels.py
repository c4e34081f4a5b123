"""Curvature measures of balls on a triangle mesh (Cohen-Steiner and Morvan 2003)."""

import numpy as np
from numpy.typing import NDArray

from subdfit.compiled import inlined_kernel, kernel

Reals = NDArray[np.float64]
Indices = NDArray[np.int32]


@inlined_kernel
def _clip(ax, ay, az, bx, by, bz, radius):  # type: ignore[no-untyped-def]
    """Parameters between which the segment ab lies inside the ball round the origin; equal if it does not."""
    dx, dy, dz = bx - ax, by - ay, bz - az
    square = dx * dx + dy * dy + dz * dz
    if square == 0.0:
        return 0.0, 0.0
    middle = -(ax * dx + ay * dy + az * dz) / square
    off = ax * ax + ay * ay + az * az - middle * middle * square
    if off >= radius * radius:
        return 0.0, 0.0
    half = np.sqrt((radius * radius - off) / square)
    low, high = min(max(middle - half, 0.0), 1.0), min(max(middle + half, 0.0), 1.0)
    return low, high


@inlined_kernel
def _sector(px, py, qx, qy, radius):  # type: ignore[no-untyped-def]
    """Signed integral of ``1 - r^2 / radius^2`` over the sector of the disk that p and q span from its centre."""
    return 0.25 * radius * radius * np.arctan2(px * qy - py * qx, px * qx + py * qy)


@inlined_kernel
def _fan(px, py, qx, qy, radius):  # type: ignore[no-untyped-def]
    """Signed integral of ``1 - r^2 / radius^2`` over the triangle of the centre, p and q, both within the disk."""
    area = 0.5 * (px * qy - py * qx)
    squares = px * px + py * py + px * qx + py * qy + qx * qx + qy * qy
    return area * (1.0 - squares / (6.0 * radius * radius))


@inlined_kernel
def _side(px, py, qx, qy, radius):  # type: ignore[no-untyped-def]
    """Signed integral over the part of the disk that lies between its centre and the segment pq."""
    low, high = _clip(px, py, 0.0, qx, qy, 0.0, radius)
    if high <= low:
        return _sector(px, py, qx, qy, radius)
    lx, ly = px + low * (qx - px), py + low * (qy - py)
    hx, hy = px + high * (qx - px), py + high * (qy - py)
    total = _fan(lx, ly, hx, hy, radius)
    if low > 0.0:
        total += _sector(px, py, lx, ly, radius)
    if high < 1.0:
        total += _sector(hx, hy, qx, qy, radius)
    return total


@kernel
def ball_measures(
    points: Reals,
    triangles: Indices,
    neighbours: Indices,
    normals: Reals,
    bend: Reals,
    centres: Reals,
    seeds: Indices,
    radii: Reals,
    start: int,
    stop: int,
    measures: Reals,
) -> None:
    """Integrate area, normal and curvature over the pieces of surface round `centres`, `start` to `stop`.

    A piece is what lies within the radius and is joined to the seed triangle inside the ball. All integrals
    carry the weight ``1 - r^2 / radius^2``, in closed form over edges and triangles.

    Parameters
    ----------
    points, triangles : the mesh; side k of a triangle joins its corners k and k + 1.
    neighbours : (m, 3) int32, the triangle beyond each side, -1 where the piece may not go on.
    normals : (m, 3) float64, unit normals, zero for triangles without area.
    bend : (m, 3) float64, what the triangle counts of the signed angle across each side, half of it as a rule.
    centres, seeds, radii : (c, 3), (c,), (c,); a seed is a triangle that holds the centre.
    measures : (c, 10) float64, written: area, normal, and xx xy xz yy yz zz of the sum over edges of
        ``angle * length * direction direction^T``.
    """
    stamp = np.full(len(triangles), -1, np.int32)
    stack = np.empty(len(triangles), np.int32)
    corner = np.empty((3, 3))
    total = np.empty(10)
    for c in range(start, stop):
        radius = radii[c]
        total[:] = 0.0
        stack[0] = seeds[c]
        stamp[seeds[c]] = c
        top = 1
        while top > 0:
            top -= 1
            f = stack[top]
            for k in range(3):
                for d in range(3):
                    corner[k, d] = points[triangles[f, k], d] - centres[c, d]
            for k in range(3):
                i = (k + 1) % 3
                low, high = _clip(
                    corner[k, 0], corner[k, 1], corner[k, 2], corner[i, 0], corner[i, 1], corner[i, 2], radius
                )
                if high <= low:
                    continue
                g = neighbours[f, k]
                if g >= 0 and stamp[g] != c:
                    stamp[g] = c
                    stack[top] = g
                    top += 1
                _add_edge(corner, k, i, low, high, radius, bend[f, k], total)
            _add_area(corner, normals, f, radius, total)
        for k in range(10):
            measures[c, k] = total[k]


@inlined_kernel
def _add_edge(corner, k, i, low, high, radius, bend, total):  # type: ignore[no-untyped-def]
    """Add an edge's share: its angle times the weighted length inside the ball, along its direction."""
    dx, dy, dz = corner[i, 0] - corner[k, 0], corner[i, 1] - corner[k, 1], corner[i, 2] - corner[k, 2]
    square = dx * dx + dy * dy + dz * dz
    length = np.sqrt(square)
    # The squared distance from the centre along the edge is quadratic: Simpson's rule is exact.
    mean = 0.0
    for s in range(3):
        t = low + 0.5 * s * (high - low)
        x, y, z = corner[k, 0] + t * dx, corner[k, 1] + t * dy, corner[k, 2] + t * dz
        mean += (4.0 if s == 1 else 1.0) / 6.0 * (1.0 - (x * x + y * y + z * z) / (radius * radius))
    share = bend * (high - low) * mean * length / square
    total[4] += share * dx * dx
    total[5] += share * dx * dy
    total[6] += share * dx * dz
    total[7] += share * dy * dy
    total[8] += share * dy * dz
    total[9] += share * dz * dz


@inlined_kernel
def _add_area(corner, normals, f, radius, total):  # type: ignore[no-untyped-def]
    """Add a triangle's weighted area inside the ball, and its normal times that area."""
    nx, ny, nz = normals[f, 0], normals[f, 1], normals[f, 2]
    if nx == 0.0 and ny == 0.0 and nz == 0.0:
        return
    height = corner[0, 0] * nx + corner[0, 1] * ny + corner[0, 2] * nz
    disk = radius * radius - height * height
    if disk <= 0.0:
        return
    # Axes in the triangle's plane: its first side, and across it.
    ux, uy, uz = corner[1, 0] - corner[0, 0], corner[1, 1] - corner[0, 1], corner[1, 2] - corner[0, 2]
    length = np.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    vx, vy, vz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
    within = np.sqrt(disk)
    area = 0.0
    for k in range(3):
        i = (k + 1) % 3
        px = corner[k, 0] * ux + corner[k, 1] * uy + corner[k, 2] * uz
        py = corner[k, 0] * vx + corner[k, 1] * vy + corner[k, 2] * vz
        qx = corner[i, 0] * ux + corner[i, 1] * uy + corner[i, 2] * uz
        qy = corner[i, 0] * vx + corner[i, 1] * vy + corner[i, 2] * vz
        area += _side(px, py, qx, qy, within)
    # In the plane at this height the weight is (disk / radius^2) (1 - s^2 / disk), s from the disk's centre.
    area *= disk / (radius * radius)
    total[0] += area
    total[1] += area * nx
    total[2] += area * ny
    total[3] += area * nz

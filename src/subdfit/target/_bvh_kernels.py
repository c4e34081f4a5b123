"""Bounding-volume hierarchy over triangles: nearest triangle, and all triangles within a radius.

The arrays `boxes`, `children`, `corners`, `rows` of a tree are described in ``_bvh_build_kernels.py``.
Kernels of other rooms may call `nearest`, `collect` and `closest_on_triangle` inside their own loops.
"""

import numpy as np
from numpy.typing import NDArray

from subdfit.compiled import inner_kernel, kernel
from subdfit.target._bvh_build_kernels import STACK_SIZE, Indices, Reals

ROOT = np.int64(0)
"""The first node; a bare 0 would have what is called with it compiled once more, for this number."""
FLAT = 1e-28
"""Squared sine of a corner below which a triangle has no plane: fused products make rounding errors of what is 0."""


@inner_kernel
def _boxes_squared(boxes: Reals, node: int, x: float, y: float, z: float) -> tuple[float, float]:
    """Squared distances of a point from both children's boxes."""
    ax = max(max(boxes[node, 0, 0] - x, x - boxes[node, 0, 3]), 0.0)
    ay = max(max(boxes[node, 0, 1] - y, y - boxes[node, 0, 4]), 0.0)
    az = max(max(boxes[node, 0, 2] - z, z - boxes[node, 0, 5]), 0.0)
    bx = max(max(boxes[node, 1, 0] - x, x - boxes[node, 1, 3]), 0.0)
    by = max(max(boxes[node, 1, 1] - y, y - boxes[node, 1, 4]), 0.0)
    bz = max(max(boxes[node, 1, 2] - z, z - boxes[node, 1, 5]), 0.0)
    return ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz


@inner_kernel
def _along(ex: float, ey: float, ez: float, px: float, py: float, pz: float) -> float:
    """Parameter in [0, 1] of the point of the segment 0 to e that is closest to p."""
    length = ex * ex + ey * ey + ez * ez
    dot = ex * px + ey * py + ez * pz
    if not dot > 0.0:
        return 0.0
    return dot / length if dot < length else 1.0


@inner_kernel
def closest_on_triangle(corners: Reals, slot: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Closest point of one triangle: ``(u, v, squared)``, the point being ``(1 - u - v) a + u b + v c``.

    The foot on the plane decides; where it lies outside, the closest point is on one of the edges that
    it lies beyond, since the gap is a combination of those edges' outward normals with positive weights.
    A triangle without area has no plane: all its edges are tried, so segments ``(a, b, b)`` are exact too.
    """
    ax, ay, az = corners[slot, 0], corners[slot, 1], corners[slot, 2]
    bx, by, bz = corners[slot, 3] - ax, corners[slot, 4] - ay, corners[slot, 5] - az
    cx, cy, cz = corners[slot, 6] - ax, corners[slot, 7] - ay, corners[slot, 8] - az
    px, py, pz = x - ax, y - ay, z - az
    nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    squared = nx * nx + ny * ny + nz * nz
    if not squared > FLAT * (bx * bx + by * by + bz * bz) * (cx * cx + cy * cy + cz * cz):
        squared = np.nan
    u = ((py * cz - pz * cy) * nx + (pz * cx - px * cz) * ny + (px * cy - py * cx) * nz) / squared
    v = ((by * pz - bz * py) * nx + (bz * px - bx * pz) * ny + (bx * py - by * px) * nz) / squared
    if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
        dx, dy, dz = px - u * bx - v * cx, py - u * by - v * cy, pz - u * bz - v * cz
        return u, v, dx * dx + dy * dy + dz * dz
    best_u, best_v, best = 0.0, 0.0, np.inf
    if not v >= 0.0:
        t = _along(bx, by, bz, px, py, pz)
        dx, dy, dz = px - t * bx, py - t * by, pz - t * bz
        best_u, best_v, best = t, 0.0, dx * dx + dy * dy + dz * dz
    if not u >= 0.0:
        t = _along(cx, cy, cz, px, py, pz)
        dx, dy, dz = px - t * cx, py - t * cy, pz - t * cz
        squared = dx * dx + dy * dy + dz * dz
        if squared < best:
            best_u, best_v, best = 0.0, t, squared
    if not u + v <= 1.0:
        ex, ey, ez = cx - bx, cy - by, cz - bz
        t = _along(ex, ey, ez, px - bx, py - by, pz - bz)
        dx, dy, dz = px - bx - t * ex, py - by - t * ey, pz - bz - t * ez
        squared = dx * dx + dy * dy + dz * dz
        if squared < best:
            best_u, best_v, best = 1.0 - t, t, squared
    return best_u, best_v, best


@kernel
def nearest(
    boxes: Reals,
    children: Indices,
    corners: Reals,
    x: float,
    y: float,
    z: float,
    best_squared: float,
    enough_squared: float,
    stack_nodes: Indices,
    stack_bounds: Reals,
) -> tuple[int, float]:
    """Slot of the triangle nearest to a point, and its squared distance.

    Parameters
    ----------
    boxes, children, corners : the tree.
    x, y, z : the point.
    best_squared : only triangles strictly nearer than this are sought; ``np.inf`` for any.
    enough_squared : the search ends at the first triangle found so near, the nearest or not.
    stack_nodes, stack_bounds : (STACK_SIZE,) int32 and float64, scratch.

    Returns
    -------
    slot, squared : ``(-1, best_squared)`` where none is nearer.
    """
    best = -1
    top = 0
    node = int(ROOT)
    if best_squared <= enough_squared:
        return best, best_squared
    while True:
        if node >= 0:
            near, far = int(children[node, 0]), int(children[node, 1])
            near_squared, far_squared = _boxes_squared(boxes, node, x, y, z)
            if far_squared < near_squared:
                near, far = far, near
                near_squared, far_squared = far_squared, near_squared
            if near_squared < best_squared:
                if far_squared < best_squared:
                    stack_nodes[top] = far
                    stack_bounds[top] = far_squared
                    top += 1
                node = near
                continue
        else:
            first, count = ~node >> 3, ~node & 7
            for slot in range(first, first + count):
                squared = closest_on_triangle(corners, slot, x, y, z)[2]
                if squared < best_squared:
                    best, best_squared = slot, squared
            if best_squared <= enough_squared:
                return best, best_squared
        while top > 0 and not stack_bounds[top - 1] < best_squared:
            top -= 1
        if top == 0:
            return best, best_squared
        top -= 1
        node = int(stack_nodes[top])


@inner_kernel
def collect(
    boxes: Reals,
    children: Indices,
    corners: Reals,
    rows: Indices,
    inflation: Reals,
    x: float,
    y: float,
    z: float,
    radius: float,
    found: Indices,
    bounds: Reals,
    stack_nodes: Indices,
) -> int:
    """List the triangles whose inflated surface may come within a radius of a point.

    Parameters
    ----------
    boxes, children, corners, rows : the tree.
    inflation : (m,) float64, a triangle.
    x, y, z, radius : the ball; triangles with ``distance - inflation <= radius`` are listed.
    found, bounds : (capacity,) int32 and float64, written: the triangles and their ``distance - inflation``,
        as many as there is room for.
    stack_nodes : (STACK_SIZE,) int32, scratch.

    Returns
    -------
    Number of triangles that qualify, which may exceed the capacity.
    """
    count = 0
    stack_nodes[0] = 0
    top = 1
    while top > 0:
        top -= 1
        node = np.int64(stack_nodes[top])
        if node >= 0:
            first_squared, second_squared = _boxes_squared(boxes, node, x, y, z)
            if second_squared <= radius * radius:
                stack_nodes[top] = children[node, 1]
                top += 1
            if first_squared <= radius * radius:
                stack_nodes[top] = children[node, 0]
                top += 1
            continue
        for slot in range(~node >> 3, (~node >> 3) + (~node & 7)):
            f = rows[slot]
            bound = np.sqrt(closest_on_triangle(corners, slot, x, y, z)[2]) - inflation[f]
            if bound <= radius:
                if count < len(found):
                    found[count], bounds[count] = f, bound
                count += 1
    return count


@kernel
def nearest_of_many(
    boxes: Reals,
    children: Indices,
    corners: Reals,
    rows: Indices,
    slots: Indices,
    queries: Reals,
    order: NDArray[np.int64],
    start: Indices,
    enough: float,
    triangle: Indices,
    uv: Reals,
    distance: Reals,
) -> None:
    """Closest point for the queries `order`, written to their places in `triangle`, `uv` and `distance`.

    ``start[q]`` is a triangle that is likely near query q, or -1. Within the distance `enough` any triangle will do.
    """
    stack_nodes = np.empty(STACK_SIZE, np.int32)
    stack_bounds = np.empty(STACK_SIZE)
    for q in order:
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        guess = slots[start[q]] if start[q] >= 0 else -1
        bound = closest_on_triangle(corners, guess, x, y, z)[2] if guess >= 0 else np.inf
        slot, squared = nearest(boxes, children, corners, x, y, z, bound, enough * enough, stack_nodes, stack_bounds)
        if slot < 0:
            slot = guess
        u, v, squared = closest_on_triangle(corners, slot, x, y, z)
        triangle[q] = rows[slot]
        uv[q, 0], uv[q, 1] = u, v
        distance[q] = np.sqrt(squared)


@kernel
def collect_for_many(
    boxes: Reals,
    children: Indices,
    corners: Reals,
    rows: Indices,
    inflation: Reals,
    queries: Reals,
    radii: Reals,
    start: int,
    stop: int,
    offsets: NDArray[np.int64],
    found: Indices,
    bounds: Reals,
) -> NDArray[np.int64]:
    """Run `collect` for queries `start` to `stop`; query q writes its results from ``offsets[q]`` on.

    `offsets` (q + 1,) int64 also says how much room each query has; returns the count of every query.
    """
    stack_nodes = np.empty(STACK_SIZE, np.int32)
    counts = np.empty(stop - start, np.int64)
    for q in range(start, stop):
        first, last = offsets[q], offsets[q + 1]
        counts[q - start] = collect(
            boxes, children, corners, rows, inflation, queries[q, 0], queries[q, 1], queries[q, 2], radii[q],
            found[first:last], bounds[first:last], stack_nodes,
        )  # fmt: skip
    return counts


@kernel
def morton_codes(points: Reals, low: Reals, scale: float, start: int, stop: int, codes: NDArray[np.uint32]) -> None:
    """Interleave 10 bits of each coordinate of ``(point - low) * scale`` into ``codes[start:stop]``."""
    for i in range(start, stop):
        code = np.uint64(0)
        for k in range(3):
            cell = np.uint64(min(max((points[i, k] - low[k]) * scale, 0.0), 1023.0))
            cell = (cell | cell << np.uint64(16)) & np.uint64(0x030000FF)
            cell = (cell | cell << np.uint64(8)) & np.uint64(0x0300F00F)
            cell = (cell | cell << np.uint64(4)) & np.uint64(0x030C30C3)
            cell = (cell | cell << np.uint64(2)) & np.uint64(0x09249249)
            code |= cell << np.uint64(k)
        codes[i] = np.uint32(code)

"""Bounding-volume hierarchy over triangles: build, refit, nearest triangle, all triangles within a radius.

Layout. Triangles are kept in *leaf order*: slot ``s`` holds triangle ``rows[s]``, its corners lie together
in ``corners[s] = (ax, ay, az, bx, ... cz)``. Inner node ``i`` has two children: ``children[i, k]`` is the
number of an inner node, or ``~(first << 3 | count)`` for a leaf of ``count`` slots from ``first``;
``boxes[i, k]`` is the child's box (low corner, high corner), grown by the triangles' inflations. Nodes come
in preorder, so that a child's number is above its parent's. The root is node 0.

Kernels of other rooms may call `nearest`, `collect` and `closest_on_triangle` inside their own loops.
"""

import numpy as np

from subdfit.compiled import kernel

LEAF_SIZE = 4
_BINS = 16
_BALANCED_DEPTH = 40

STACK_SIZE = 80
"""Entries that a stack for `nearest` and `collect` needs: below depth 40 every split halves, so 72 suffice."""


@kernel
def build(triangle_boxes, rows, boxes, children):
    """Build the tree over the boxes of the triangles and return its number of inner nodes.

    Parameters
    ----------
    triangle_boxes : (m, 6) float64, low corner then high corner; m >= 1.
    rows : (m,) int32, the numbers 0 to m - 1; reordered in place to leaf order.
    boxes : (max(m - 1, 1), 2, 6) float64, written.
    children : (max(m - 1, 1), 2) int32, written.
    """
    todo = np.empty((STACK_SIZE, 5), np.int64)
    bin_boxes = np.empty((_BINS, 6))
    bin_counts = np.empty(_BINS, np.int64)
    costs = np.empty(_BINS)
    box = np.empty(6)
    centres = np.empty(6)
    todo[0, 0], todo[0, 1], todo[0, 2] = 0, len(rows), -1
    todo[0, 3], todo[0, 4] = 0, 0
    top = 1
    count = 0
    while top > 0:
        top -= 1
        first, last, parent, side, depth = todo[top, 0], todo[top, 1], todo[top, 2], todo[top, 3], todo[top, 4]
        _bound(triangle_boxes, rows, first, last, box, centres)
        if parent >= 0:
            leaf = last - first <= LEAF_SIZE
            children[parent, side] = ~(first << 3 | (last - first)) if leaf else count
            for k in range(6):
                boxes[parent, side, k] = box[k]
            if leaf:
                continue
        middle = (first + last) // 2
        if depth < _BALANCED_DEPTH:
            middle = _split(triangle_boxes, rows, first, last, centres, bin_boxes, bin_counts, costs)
        todo[top, 0], todo[top, 1], todo[top, 2] = middle, last, count
        todo[top, 3], todo[top, 4] = 1, depth + 1
        todo[top + 1, 0], todo[top + 1, 1], todo[top + 1, 2] = first, middle, count
        todo[top + 1, 3], todo[top + 1, 4] = 0, depth + 1
        top += 2
        count += 1
    return count


@kernel
def _bound(triangle_boxes, rows, first, last, box, centres):
    """Set `box` to the union of the triangles' boxes, and `centres` to the box of twice their centres."""
    low_x = low_y = low_z = centre_low_x = centre_low_y = centre_low_z = np.inf
    high_x = high_y = high_z = centre_high_x = centre_high_y = centre_high_z = -np.inf
    for i in range(first, last):
        f = rows[i]
        ax, bx = triangle_boxes[f, 0], triangle_boxes[f, 3]
        ay, by = triangle_boxes[f, 1], triangle_boxes[f, 4]
        az, bz = triangle_boxes[f, 2], triangle_boxes[f, 5]
        low_x, high_x = min(low_x, ax), max(high_x, bx)
        low_y, high_y = min(low_y, ay), max(high_y, by)
        low_z, high_z = min(low_z, az), max(high_z, bz)
        centre_low_x, centre_high_x = min(centre_low_x, ax + bx), max(centre_high_x, ax + bx)
        centre_low_y, centre_high_y = min(centre_low_y, ay + by), max(centre_high_y, ay + by)
        centre_low_z, centre_high_z = min(centre_low_z, az + bz), max(centre_high_z, az + bz)
    box[0], box[1], box[2], box[3], box[4], box[5] = low_x, low_y, low_z, high_x, high_y, high_z
    centres[0], centres[1], centres[2] = centre_low_x, centre_low_y, centre_low_z
    centres[3], centres[4], centres[5] = centre_high_x, centre_high_y, centre_high_z


@kernel
def _split(triangle_boxes, rows, first, last, centres, bin_boxes, bin_counts, costs):
    """Reorder ``rows[first:last]`` in two parts and return where the second begins.

    Surface-area heuristic over equal bins along the longest side of the box of the centres (Wald, On fast
    construction of SAH-based bounding volume hierarchies, 2007). Halves where all centres coincide.
    """
    axis = 0
    for k in range(1, 3):
        if centres[3 + k] - centres[k] > centres[3 + axis] - centres[axis]:
            axis = k
    low = centres[axis]
    extent = centres[3 + axis] - low
    if not extent > 1e-290:
        return (first + last) // 2
    scale = _BINS * (1.0 - 1e-12) / extent
    for b in range(_BINS):
        bin_counts[b] = 0
        for k in range(3):
            bin_boxes[b, k], bin_boxes[b, 3 + k] = np.inf, -np.inf
    for i in range(first, last):
        f = rows[i]
        b = int((triangle_boxes[f, axis] + triangle_boxes[f, 3 + axis] - low) * scale)
        bin_counts[b] += 1
        for k in range(3):
            bin_boxes[b, k] = min(bin_boxes[b, k], triangle_boxes[f, k])
            bin_boxes[b, 3 + k] = max(bin_boxes[b, 3 + k], triangle_boxes[f, 3 + k])
    cut = _best_cut(bin_boxes, bin_counts, costs)
    i, j = first, last - 1
    while i <= j:
        f = rows[i]
        if int((triangle_boxes[f, axis] + triangle_boxes[f, 3 + axis] - low) * scale) < cut:
            i += 1
        else:
            rows[i], rows[j] = rows[j], f
            j -= 1
    return i


@kernel
def _best_cut(bin_boxes, bin_counts, costs):
    """Bin that begins the second part in the cheapest split: area times count, summed over both parts."""
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    count = 0
    for b in range(_BINS - 1, 0, -1):
        low_x, high_x = min(low_x, bin_boxes[b, 0]), max(high_x, bin_boxes[b, 3])
        low_y, high_y = min(low_y, bin_boxes[b, 1]), max(high_y, bin_boxes[b, 4])
        low_z, high_z = min(low_z, bin_boxes[b, 2]), max(high_z, bin_boxes[b, 5])
        count += bin_counts[b]
        x, y, z = high_x - low_x, high_y - low_y, high_z - low_z
        costs[b] = count * (x * y + y * z + z * x)
    low_x = low_y = low_z = np.inf
    high_x = high_y = high_z = -np.inf
    count = 0
    best, cut = np.inf, 1
    for b in range(_BINS - 1):
        low_x, high_x = min(low_x, bin_boxes[b, 0]), max(high_x, bin_boxes[b, 3])
        low_y, high_y = min(low_y, bin_boxes[b, 1]), max(high_y, bin_boxes[b, 4])
        low_z, high_z = min(low_z, bin_boxes[b, 2]), max(high_z, bin_boxes[b, 5])
        count += bin_counts[b]
        x, y, z = high_x - low_x, high_y - low_y, high_z - low_z
        cost = count * (x * y + y * z + z * x) + costs[b + 1]
        if cost < best:
            best, cut = cost, b + 1
    return cut


@kernel
def triangle_boxes(points, triangles, inflation, start, stop, boxes):
    """Write the boxes of triangles `start` to `stop`, grown by their inflation: low corner, high corner."""
    for f in range(start, stop):
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        for k in range(3):
            x, y, z = points[a, k], points[b, k], points[c, k]
            boxes[f, k] = min(x, min(y, z)) - inflation[f]
            boxes[f, 3 + k] = max(x, max(y, z)) + inflation[f]


@kernel
def pack_corners(points, triangles, rows, start, stop, corners):
    """Write the corners of slots `start` to `stop`."""
    for s in range(start, stop):
        for k in range(3):
            p = triangles[rows[s], k]
            corners[s, 3 * k], corners[s, 3 * k + 1], corners[s, 3 * k + 2] = points[p, 0], points[p, 1], points[p, 2]


@kernel
def refit(children, corners, rows, inflation, boxes):
    """Recompute all boxes from the corners, children before parents."""
    for i in range(len(children) - 1, -1, -1):
        for side in range(2):
            child = np.int64(children[i, side])
            for k in range(3):
                low, high = np.inf, -np.inf
                if child >= 0:
                    low = min(boxes[child, 0, k], boxes[child, 1, k])
                    high = max(boxes[child, 0, 3 + k], boxes[child, 1, 3 + k])
                else:
                    first = ~child >> 3
                    for s in range(first, first + (~child & 7)):
                        x, y, z, r = corners[s, k], corners[s, 3 + k], corners[s, 6 + k], inflation[rows[s]]
                        low, high = min(low, min(x, min(y, z)) - r), max(high, max(x, max(y, z)) + r)
                boxes[i, side, k], boxes[i, side, 3 + k] = low, high


@kernel
def _box_squared(boxes, node, side, x, y, z):
    """Squared distance of a point from a child's box."""
    dx = max(max(boxes[node, side, 0] - x, x - boxes[node, side, 3]), 0.0)
    dy = max(max(boxes[node, side, 1] - y, y - boxes[node, side, 4]), 0.0)
    dz = max(max(boxes[node, side, 2] - z, z - boxes[node, side, 5]), 0.0)
    return dx * dx + dy * dy + dz * dz


@kernel
def _along(ex, ey, ez, px, py, pz):
    """Parameter in [0, 1] of the point of the segment 0 to e that is closest to p."""
    length = ex * ex + ey * ey + ez * ez
    dot = ex * px + ey * py + ez * pz
    if not dot > 0.0:
        return 0.0
    return dot / length if dot < length else 1.0


@kernel
def closest_on_triangle(corners, slot, x, y, z):
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
def nearest(boxes, children, corners, x, y, z, best_squared, stack_nodes, stack_bounds):
    """Slot of the triangle nearest to a point, and its squared distance.

    Parameters
    ----------
    boxes, children, corners : the tree, as described at the top of this file.
    x, y, z : the point.
    best_squared : only triangles strictly nearer than this are sought; ``np.inf`` for any.
    stack_nodes, stack_bounds : (STACK_SIZE,) int32 and float64, scratch.

    Returns
    -------
    slot, squared : ``(-1, best_squared)`` where none is nearer.
    """
    best = -1
    top = 0
    node = np.int64(0)
    while True:
        if node >= 0:
            near, far = np.int64(children[node, 0]), np.int64(children[node, 1])
            near_squared = _box_squared(boxes, node, 0, x, y, z)
            far_squared = _box_squared(boxes, node, 1, x, y, z)
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
        while top > 0 and not stack_bounds[top - 1] < best_squared:
            top -= 1
        if top == 0:
            return best, best_squared
        top -= 1
        node = np.int64(stack_nodes[top])


@kernel
def collect(boxes, children, corners, rows, inflation, x, y, z, radius, found, bounds, stack_nodes):
    """List the triangles whose inflated surface may come within a radius of a point.

    Parameters
    ----------
    boxes, children, corners, rows : the tree, as described at the top of this file.
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
            for side in range(1, -1, -1):
                if _box_squared(boxes, node, side, x, y, z) <= radius * radius:
                    stack_nodes[top] = children[node, side]
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
def nearest_of_many(boxes, children, corners, rows, slots, queries, order, start, triangle, uv, distance):
    """Closest point for the queries `order`, written to their places in `triangle`, `uv` and `distance`.

    ``start[q]`` is a triangle that is likely near query q, or -1.
    """
    stack_nodes = np.empty(STACK_SIZE, np.int32)
    stack_bounds = np.empty(STACK_SIZE)
    for q in order:
        x, y, z = queries[q, 0], queries[q, 1], queries[q, 2]
        guess = slots[start[q]] if start[q] >= 0 else -1
        bound = closest_on_triangle(corners, guess, x, y, z)[2] if guess >= 0 else np.inf
        slot, squared = nearest(boxes, children, corners, x, y, z, bound, stack_nodes, stack_bounds)
        if slot < 0:
            slot = guess
        u, v, squared = closest_on_triangle(corners, slot, x, y, z)
        triangle[q] = rows[slot]
        uv[q, 0], uv[q, 1] = u, v
        distance[q] = np.sqrt(squared)


@kernel
def collect_for_many(boxes, children, corners, rows, inflation, queries, radii, start, stop, offsets, found, bounds):
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
def morton_codes(points, low, scale, start, stop, codes):
    """Interleave 10 bits of each coordinate of ``(point - low) * scale`` into ``codes[start:stop]`` (uint32)."""
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

"""Bounding-volume hierarchy over triangles: building it, and following moved points.

Triangles are kept in *leaf order*: slot ``s`` holds triangle ``rows[s]``, its corners lie together in
``corners[s] = (ax, ay, az, bx, ... cz)``. Inner node ``i`` has two children: ``children[i, k]`` is the
number of an inner node, or ``~(first << 3 | count)`` for a leaf of ``count`` slots from ``first``;
``boxes[i, k]`` is the child's box (low corner, high corner), grown by the triangles' inflations. Nodes come
in preorder, so that a child's number is above its parent's. The root is node 0.
"""

import numpy as np
from numpy.typing import NDArray

from subdfit.compiled import inner_kernel, kernel

Reals = NDArray[np.float64]
Indices = NDArray[np.int32]

LEAF_SIZE = 4
_BINS = 16
_BALANCED_DEPTH = 40

STACK_SIZE = 80
"""Entries that a stack of nodes needs: below depth 40 every split halves, so no tree is deeper than 72."""


@kernel
def build(triangle_boxes: Reals, rows: Indices, boxes: Reals, children: Indices) -> int:
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
        first, last = todo[top, 0], todo[top, 1]
        parent, side, depth = todo[top, 2], todo[top, 3], todo[top, 4]
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


@inner_kernel
def _bound(triangle_boxes: Reals, rows: Indices, first: int, last: int, box: Reals, centres: Reals) -> None:
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


@inner_kernel
def _split(
    triangle_boxes: Reals,
    rows: Indices,
    first: int,
    last: int,
    centres: Reals,
    bin_boxes: Reals,
    bin_counts: NDArray[np.int64],
    costs: Reals,
) -> int:
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


@inner_kernel
def _best_cut(bin_boxes: Reals, bin_counts: NDArray[np.int64], costs: Reals) -> int:
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
def triangle_boxes(points: Reals, triangles: Indices, inflation: Reals, start: int, stop: int, boxes: Reals) -> None:
    """Write the boxes of triangles `start` to `stop`, grown by their inflation: low corner, high corner."""
    for f in range(start, stop):
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        for k in range(3):
            x, y, z = points[a, k], points[b, k], points[c, k]
            boxes[f, k] = min(x, min(y, z)) - inflation[f]
            boxes[f, 3 + k] = max(x, max(y, z)) + inflation[f]


@kernel
def pack_corners(points: Reals, triangles: Indices, rows: Indices, start: int, stop: int, corners: Reals) -> None:
    """Write the corners of slots `start` to `stop`."""
    for s in range(start, stop):
        for k in range(3):
            for d in range(3):
                corners[s, 3 * k + d] = points[triangles[rows[s], k], d]


@kernel
def refit(children: Indices, corners: Reals, rows: Indices, inflation: Reals, boxes: Reals) -> None:
    """Recompute all boxes from the corners, children before parents."""
    for i in range(len(children) - 1, -1, -1):
        for side in range(2):
            child = int(children[i, side])
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

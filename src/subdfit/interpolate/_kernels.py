"""Products with the limit matrix, and the steps of the iterations, fused so that each passes over the points once.

Matrices are in CSR form: `offsets` int64, `columns` int32 ascending in each row, `values`. Points are (n, 3).
"""

import numpy as np

from subdfit.compiled import inlined_kernel, kernel


@inlined_kernel
def row_times(offsets, columns, values, x, i):  # type: ignore[no-untyped-def]
    """Row i of the matrix times three columns."""
    a = b = c = 0.0
    for k in range(offsets[i], offsets[i + 1]):
        w, j = values[k], columns[k]
        a += w * x[j, 0]
        b += w * x[j, 1]
        c += w * x[j, 2]
    return a, b, c


@kernel
def product(offsets, columns, values, weight, x, start, stop, out):  # type: ignore[no-untyped-def]
    """Write rows ``start`` to ``stop`` of the matrix times `x` into `out`; return their part of x^T D B x."""
    total = 0.0
    for i in range(start, stop):
        a, b, c = row_times(offsets, columns, values, x, i)
        out[i, 0], out[i, 1], out[i, 2] = a, b, c
        total += weight[i] * (a * x[i, 0] + b * x[i, 1] + c * x[i, 2])
    return total


@kernel
def gaps(offsets, columns, values, data, v, start, stop, out):  # type: ignore[no-untyped-def]
    """Write the lengths of rows ``start`` to ``stop`` of data - B v into `out`."""
    for i in range(start, stop):
        a, b, c = row_times(offsets, columns, values, v, i)
        a, b, c = data[i, 0] - a, data[i, 1] - b, data[i, 2] - c
        out[i] = np.sqrt(a * a + b * b + c * c)


@kernel
def correct(offsets, columns, values, data, v, before, share, carry, start, stop, out):  # type: ignore[no-untyped-def]
    """One step of an iteration without inner products: v + share (data - B v) + carry (v - before), into `out`.

    Returns the largest squared length of a row of data - B v.
    """
    farthest = 0.0
    for i in range(start, stop):
        a, b, c = row_times(offsets, columns, values, v, i)
        a, b, c = data[i, 0] - a, data[i, 1] - b, data[i, 2] - c
        out[i, 0] = v[i, 0] + share * a + carry * (v[i, 0] - before[i, 0])
        out[i, 1] = v[i, 1] + share * b + carry * (v[i, 1] - before[i, 1])
        out[i, 2] = v[i, 2] + share * c + carry * (v[i, 2] - before[i, 2])
        farthest = max(farthest, a * a + b * b + c * c)
    return farthest


@kernel
def advance(step, direction, image, weight, x, residual, start, stop):  # type: ignore[no-untyped-def]
    """Go `step` along the direction, whose product is `image`; return r^T D r and the longest squared row of r."""
    total = farthest = 0.0
    for i in range(start, stop):
        square = 0.0
        for d in range(3):
            x[i, d] += step * direction[i, d]
            residual[i, d] -= step * image[i, d]
            square += residual[i, d] * residual[i, d]
        total += weight[i] * square
        farthest = max(farthest, square)
    return total, farthest


@kernel
def turn(share, residual, direction, start, stop):  # type: ignore[no-untyped-def]
    """Make the next direction: residual + share direction."""
    for i in range(start, stop):
        for d in range(3):
            direction[i, d] = residual[i, d] + share * direction[i, d]


@kernel
def breadth_first(offsets, columns):  # type: ignore[no-untyped-def]
    """The order in which a breadth-first search along entries meets the rows (Cuthill and McKee 1969).

    Returns
    -------
    order, number : int32, old numbers by the new ones, and new ones by the old.
    """
    count = len(offsets) - 1
    order, number = np.empty(count, np.int32), np.full(count, -1, np.int32)
    tail = seed = 0
    for head in range(count):
        if head == tail:
            while number[seed] >= 0:
                seed += 1
            order[tail], number[seed] = seed, tail
            tail += 1
        for k in range(offsets[order[head]], offsets[order[head] + 1]):
            j = columns[k]
            if number[j] < 0:
                order[tail], number[j] = j, tail
                tail += 1
    return order, number


@kernel
def renumber(offsets, columns, values, order, number, starts, start, stop, into, copied):  # type: ignore[no-untyped-def]
    """Write the new rows ``start`` to ``stop``, which begin at `starts`, with new columns, ascending again."""
    for i in range(start, stop):
        first, row = starts[i], order[i]
        for k in range(offsets[row], offsets[row + 1]):
            place, column = first + k - offsets[row], number[columns[k]]
            while place > first and into[place - 1] > column:
                into[place], copied[place] = into[place - 1], copied[place - 1]
                place -= 1
            into[place], copied[place] = column, values[k]


@inlined_kernel
def entry(offsets, columns, values, i, j):  # type: ignore[no-untyped-def]
    """Entry (i, j) of the matrix, by bisection."""
    low, high = offsets[i], offsets[i + 1]
    while low < high:
        middle = (low + high) // 2
        if columns[middle] < j:
            low = middle + 1
        else:
            high = middle
    return values[low] if low < offsets[i + 1] and columns[low] == j else 0.0


@kernel
def spread_weights(offsets, columns, values, free):  # type: ignore[no-untyped-def]
    """Weights d with d_i B_ij = d_j B_ji along the edges of a breadth-first forest over the free rows; 0 elsewhere.

    A row that cannot get a positive weight stops the search, and keeps the weight 0.
    """
    count = len(free)
    weight = np.zeros(count)
    waiting = np.empty(count, np.int32)
    for seed in range(count):
        if not free[seed] or weight[seed] > 0:
            continue
        weight[seed] = 1.0
        waiting[0] = seed
        head, tail = 0, 1
        while head < tail:
            i = waiting[head]
            head += 1
            for k in range(offsets[i], offsets[i + 1]):
                j, there = columns[k], values[k]
                if not free[j] or weight[j] > 0 or there == 0.0:
                    continue
                back = entry(offsets, columns, values, j, i)
                if there * back <= 0:
                    return weight
                weight[j] = weight[i] * there / back
                waiting[tail] = j
                tail += 1
    return weight


@kernel
def asymmetry(offsets, columns, values, free, weight, start, stop):  # type: ignore[no-untyped-def]
    """Largest abs(d_i B_ij - d_j B_ji) / (d_i B_ii), j < i, among the free rows ``start`` to ``stop``."""
    worst = 0.0
    for i in range(start, stop):
        if free[i]:
            own = weight[i] * abs(entry(offsets, columns, values, i, i))
            for k in range(offsets[i], offsets[i + 1]):
                j = columns[k]
                if j < i and free[j]:
                    here, there = weight[i] * values[k], weight[j] * entry(offsets, columns, values, j, i)
                    worst = max(worst, abs(here - there) / own)
    return worst


@inlined_kernel
def find_root(parent, parity, v):  # type: ignore[no-untyped-def]
    """Root of v's tree and v's parity to it; the path is shortened."""
    root, across = v, 0
    while parent[root] != root:
        across ^= parity[root]
        root = parent[root]
    total = across
    while parent[v] != root and v != root:
        above, own = parent[v], parity[v]
        parent[v], parity[v] = root, across
        across ^= own
        v = above
    return root, total


@kernel
def two_colours(edges, count):  # type: ignore[no-untyped-def]
    """Colour vertices +1 and -1 so that edges (e, 2) join opposite ones, 0 where that cannot be.

    Returns
    -------
    sign : int8 (count,); component : int32 (count,), a vertex that names each vertex's component.
    """
    parent = np.arange(count).astype(np.int32)
    parity = np.zeros(count, np.int8)
    odd = np.zeros(count, np.bool_)
    for e in range(len(edges)):
        a, to_a = find_root(parent, parity, edges[e, 0])
        b, to_b = find_root(parent, parity, edges[e, 1])
        if a == b:
            odd[a] |= to_a == to_b
        else:
            parent[b], parity[b] = a, 1 ^ to_a ^ to_b
            odd[a] |= odd[b]
    sign = np.empty(count, np.int8)
    for v in range(count):
        root, colour = find_root(parent, parity, v)
        sign[v] = 0 if odd[root] else 1 - 2 * colour
        parent[v] = root
        parity[v] = colour
    return sign, parent

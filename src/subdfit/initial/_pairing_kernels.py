"""Matching of neighbouring triangles, greedily and along alternating paths."""

import numpy as np

from subdfit.compiled import inner_kernel, kernel

MOST_VISITS = 400
"""Triangles looked at for one alternating path."""


@inner_kernel
def may_lose(h, corners, least, faces_at):  # type: ignore[no-untyped-def]
    """Whether both ends of side `h` have a face to spare."""
    a, b = corners[h], corners[h + 1 if h % 3 < 2 else h - 2]
    return faces_at[a] > least[a] and faces_at[b] > least[b]


@inner_kernel
def change(h, by, corners, twin, mate, faces_at):  # type: ignore[no-untyped-def]
    """Join (`by` = -1) or part (+1) the two triangles beside `h`."""
    g = twin[h]
    mate[h // 3] = h if by < 0 else -1
    mate[g // 3] = g if by < 0 else -1
    faces_at[corners[h]] += by
    faces_at[corners[g]] += by


@kernel
def match_greedily(order, corners, twin, least, faces_at, mate):  # type: ignore[no-untyped-def]
    """Join free triangles across the sides in `order`, best first, while their ends keep `least` faces."""
    for h in order:
        free = mate[h // 3] < 0 and mate[twin[h] // 3] < 0
        if free and may_lose(h, corners, least, faces_at):
            change(h, -1, corners, twin, mate, faces_at)


@kernel
def lengthen_matching(allowed, corners, twin, least, faces_at, mate):  # type: ignore[no-untyped-def]
    """Join free triangles in pairs along alternating paths: shortest first, blossoms are not looked for."""
    count = len(mate)
    seen = np.full(count, -1, np.int32)
    entered = np.empty(count, np.int32)
    queue = np.empty(MOST_VISITS + 4, np.int32)
    for root in range(count):
        if mate[root] >= 0:
            continue
        queue[0], head, tail = root, 0, 1
        seen[root] = root
        while head < tail and tail < MOST_VISITS and mate[root] < 0:
            f = queue[head]
            head += 1
            for h in range(3 * f, 3 * f + 3):
                g = twin[h] // 3
                if not allowed[h] or seen[g] == root:
                    continue
                if mate[g] < 0:
                    if swap_path(h, root, entered, corners, twin, least, faces_at, mate):
                        break
                    continue
                other = twin[mate[g]] // 3
                seen[g] = seen[other] = root
                entered[other] = h
                queue[tail] = other
                tail += 1


@inner_kernel
def swap_path(last, root, entered, corners, twin, least, faces_at, mate):  # type: ignore[no-untyped-def]
    """Exchange joined and free sides from `last` back to `root`; undone where a vertex would keep too few faces."""
    path = np.empty(2 * MOST_VISITS, np.int32)
    size = 0
    h = last
    while True:
        path[size] = h
        size += 1
        f = h // 3
        if f == root:
            break
        path[size] = mate[f]
        size += 1
        h = entered[f]
    for k in range(1, size, 2):
        change(path[k], 1, corners, twin, mate, faces_at)
    done = 0
    for k in range(0, size, 2):
        if not may_lose(path[k], corners, least, faces_at):
            break
        change(path[k], -1, corners, twin, mate, faces_at)
        done = k + 2
    if done >= size:
        return True
    for k in range(0, done, 2):
        change(path[k], 1, corners, twin, mate, faces_at)
    for k in range(1, size, 2):
        change(path[k], -1, corners, twin, mate, faces_at)
    return False

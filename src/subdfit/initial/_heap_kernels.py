"""A heap of numbered entries, the best grade on top, in which each entry knows its place.

``heap[:sizes[0]]`` are the entries; ``place[e]`` is where entry ``e`` stands, -1 where it does not. Of equal grades the
lower number is better, so that the order is always the same.
"""

from subdfit.compiled import inner_kernel


@inner_kernel
def put(entry, grade, heap, place, sizes):  # type: ignore[no-untyped-def]
    """Add an entry, or move it to where its grade belongs now."""
    if place[entry] < 0:
        place[entry] = sizes[0]
        heap[sizes[0]] = entry
        sizes[0] += 1
    _settle(place[entry], grade, heap, place, sizes[0])


@inner_kernel
def take_out(entry, grade, heap, place, sizes):  # type: ignore[no-untyped-def]
    """Remove an entry, if it is there."""
    slot = place[entry]
    if slot >= 0:
        place[entry] = -1
        sizes[0] -= 1
        last = heap[sizes[0]]
        if last != entry:
            heap[slot] = last
            place[last] = slot
            _settle(slot, grade, heap, place, sizes[0])


@inner_kernel
def _better(p, q, grade):  # type: ignore[no-untyped-def]
    return grade[p] > grade[q] or (grade[p] == grade[q] and p < q)


@inner_kernel
def _settle(slot, grade, heap, place, size):  # type: ignore[no-untyped-def]
    """Move the entry in `slot` up or down to where it belongs."""
    entry = heap[slot]
    while slot > 0 and _better(entry, heap[(slot - 1) // 2], grade):
        above = (slot - 1) // 2
        heap[slot] = heap[above]
        place[heap[slot]] = slot
        slot = above
    while 2 * slot + 1 < size:
        below = 2 * slot + 1
        if below + 1 < size and _better(heap[below + 1], heap[below], grade):
            below += 1
        if _better(entry, heap[below], grade):
            break
        heap[slot] = heap[below]
        place[heap[slot]] = slot
        slot = below
    heap[slot] = entry
    place[entry] = slot

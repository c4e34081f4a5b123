"""Types that a process keeps: the same bytes whatever they are made with, and tables that outlive the store's array."""

from itertools import product

import numpy as np

from subdfit.schemes._quad_triangle_kinds import Corner, Strip
from subdfit.schemes._quad_triangle_types import _types
from subdfit.schemes._type_store import Kept, PlacedType, TypeStore


def made(kinds, arena):
    found = []
    for kind in kinds:
        begin, place = arena.room(kind)
        place[:] = kind / 7
        found.append(PlacedType(kind, 0, (-1, -1, -1), begin))
    return found


def matrices(types, row, count):
    return types.matrices[types.offset[row] :][:count]


def test_types_are_the_same_bytes_whatever_they_are_made_with():
    orders = ["".join(word) for word in product("QT", repeat=4)][1:]
    kinds = [Corner(order, 0, closed=True, dart=False, pinned=False) for order in orders]
    kinds += [Corner("TQQ", i, closed=False, dart=False, pinned=pinned) for i in range(3) for pinned in (False, True)]
    kinds += [Corner("QTTQ", i, closed=True, dart=True, pinned=False) for i in range(4)] + [Strip(3, 2)]
    together = TypeStore(_types).types(kinds)
    for row, kind in reversed(list(enumerate(kinds))):
        alone = TypeStore(_types).types([kind])
        for one, all_of_them in zip(alone[:3], together[:3], strict=True):
            np.testing.assert_array_equal(one[0], all_of_them[row])
        np.testing.assert_array_equal(alone.matrices, matrices(together, row, len(alone.matrices)))


def test_a_store_makes_a_type_once_until_it_holds_too_much():
    calls = []
    store = TypeStore(lambda kinds, arena: calls.append(list(kinds)) or made(kinds, arena), limit=20)
    first = store.types([5, 3, 5])
    second = store.types([3, 8])
    assert calls == [[5, 3], [8]]
    third = store.types([5, 9])
    assert calls[2:] == [[9], [5, 9]]
    for types, kinds in ((first, [5, 3, 5]), (second, [3, 8]), (third, [5, 9])):
        for row, kind in enumerate(kinds):
            np.testing.assert_array_equal(matrices(types, row, kind), np.full(kind, kind / 7))


def test_values_are_kept_up_to_their_number():
    calls = []
    kept = Kept(lambda kinds: calls.append(list(kinds)) or [2 * kind for kind in kinds], limit=3)
    assert kept.of([1, 2, 1]) == [2, 4, 2]
    assert kept.of([2, 3]) == [4, 6]
    assert kept.of([4, 1]) == [8, 2]
    assert calls == [[1, 2], [3], [4, 1]]

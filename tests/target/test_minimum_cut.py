"""The cheapest cut between two nodes."""

from itertools import product

import numpy as np
import pytest

from subdfit.target.minimum_cut import source_side


def cost(side, heads, tails, capacity):
    return capacity[side[heads] & ~side[tails]].sum()


@pytest.mark.parametrize("seed", range(5))
def test_no_other_cut_is_cheaper(seed):
    rng = np.random.default_rng(seed)
    heads, tails = np.nonzero((rng.random((8, 8)) < 0.5) & ~np.eye(8, dtype=bool))
    capacity = rng.random(len(heads))
    side = source_side(heads, tails, capacity, 8)
    assert side[0]
    assert not side[1]
    others = [np.array([True, False, *rest]) for rest in product([False, True], repeat=6)]
    least = min(cost(other, heads, tails, capacity) for other in others)
    assert cost(side, heads, tails, capacity) == pytest.approx(least, rel=1e-6)


def test_the_narrowest_place_of_a_long_strip_is_cut():
    """Ten thousand ranks of a hundred nodes, linked to those before and behind; the links behind one rank cost half."""
    ranks, width, narrow = 10_000, 100, 7_000
    node = 2 + np.arange(ranks * width).reshape(ranks, width)
    pairs = np.stack([node[:-1].ravel(), node[1:].ravel()])
    price = np.where(np.arange(ranks - 1) == narrow, 0.5, 1.0).repeat(width)
    ends = np.stack([np.zeros(width, np.int64), node[0]]), np.stack([node[-1], np.ones(width, np.int64)])
    links = np.concatenate([pairs, *ends], axis=1)
    capacity = np.concatenate([price, np.full(2 * width, 1e5)])
    side = source_side(links[0], links[1], capacity, 2 + ranks * width)
    np.testing.assert_array_equal(side[node], np.broadcast_to(np.arange(ranks)[:, None] <= narrow, node.shape))

"""The cheapest cut that parts one node of a graph from another."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

_UNITS = 2.0**30
"""Whole units of flow that all links together may take, so that no residue overflows 32 bits."""


def source_side(
    heads: NDArray[np.int64], tails: NDArray[np.int64], capacity: NDArray[np.float64], count: int
) -> NDArray[np.bool_]:
    """Nodes on the side of node 0 in a minimum cut between nodes 0 and 1, (count,).

    Parameters
    ----------
    heads, tails : (k,) int64, nodes from and to which links lead.
    capacity : (k,) float64, what it costs to cut them.
    count : number of nodes.
    """
    whole = np.round(capacity * (_UNITS / max(float(capacity.sum()), 1e-300))).astype(np.int32)
    graph = csr_array(coo_array((whole, (heads, tails)), shape=(count, count)))
    flow = maximum_flow(graph, 0, 1).flow
    left = csr_array(graph - flow)
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    side = np.zeros(count, np.bool_)
    side[breadth_first_order(left, 0, return_predecessors=False)] = True
    return side

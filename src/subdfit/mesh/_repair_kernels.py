"""Mending kernels over arrays."""

import numpy as np

from subdfit.compiled import kernel


@kernel
def merge_labels(first, second, count):  # type: ignore[no-untyped-def]
    """Label ``range(count)`` so that ``first[i]`` and ``second[i]`` agree for all i: each set's lowest member.

    Disjoint sets with path halving (Tarjan and van Leeuwen 1984); the lowest member is the root, so that
    labels do not depend on the order of the pairs.
    """
    label = np.arange(count)
    for i in range(len(first)):
        a, b = first[i], second[i]
        while label[a] != a:
            label[a] = label[label[a]]
            a = label[a]
        while label[b] != b:
            label[b] = label[label[b]]
            b = label[b]
        if a < b:
            label[b] = a
        else:
            label[a] = b
    for i in range(count):
        label[i] = label[label[i]]
    return label

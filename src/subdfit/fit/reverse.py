"""The reverse side: samples of the surface that lie too far from the target."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.fit.state import FitState
from subdfit.limit.tessellate import lattice
from subdfit.measure import reverse_segments

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Strays:
    """Samples of a surface that lie off the target by more than they may.

    Attributes
    ----------
    face, uv : (k,) and (k, 2), where they lie.
    gap : (k, 3), from the sample to the target, less what the target's faceting allows.
    """

    face: NDArray[np.int32]
    uv: Floats
    gap: Floats

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.face)

    def joined(self, other: "Strays") -> "Strays":
        """Both, each sample once."""
        face = np.concatenate([self.face, other.face])
        uv, gap = np.concatenate([self.uv, other.uv]), np.concatenate([self.gap, other.gap])
        _, first = np.unique(np.column_stack([face, uv]), axis=0, return_index=True)
        return Strays(face[first], uv[first], gap[first])

    def follow(self, state: FitState) -> "Strays":
        """The same samples on another surface of the same connectivity."""
        return Strays(self.face, self.uv, gaps(state, self.face, self.uv))


def gaps(state: FitState, face: NDArray[np.int32], uv: Floats) -> Floats:
    """From samples of the surface to the target, (k, 3): what exceeds the sagitta of the target's face."""
    target = state.data.target
    position = state.surface.evaluate(face, uv).position
    found = target.tree.closest(position)
    beyond = np.maximum(found.distance - target.sagitta[found.triangle], 0.0)
    share = np.divide(beyond, found.distance, out=np.zeros_like(beyond), where=found.distance > 0)
    return share[:, None] * (target.on_triangles(found.triangle, found.uv) - position)


def strays(state: FitState, bound: float) -> Strays:
    """Find the samples that lie farther from the target than `bound` and the sagitta of the face they meet.

    The samples are those of the certificate. A point cloud has no reverse side: none stray.
    """
    if not state.data.target.is_mesh:
        return Strays(np.empty(0, np.int32), np.empty((0, 2)), np.empty((0, 3)))
    grid = lattice(state.surface.domain, reverse_segments(state.surface.domain.face_count))
    gap = gaps(state, grid.face, grid.uv)
    far = np.flatnonzero(np.linalg.norm(gap, axis=1) > bound)
    return Strays(grid.face[far], np.ascontiguousarray(grid.uv[far]), gap[far])

"""Control edges that cross, seen along the normals of the surface on which they stand for paths."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_TOUCHING = 1e-9
"""Share of an edge's length beyond its ends up to which it still crosses: through another's end, it does."""
_NEAR = 0.5
"""Distance along the normal, as a share of the longer edge, up to which two edges lie on one sheet of the surface."""


@dataclass(frozen=True)
class Edges:
    """Straight edges over a surface.

    Attributes
    ----------
    ends : (e, 2) int64, the control points that they join.
    points : (e, 2, 3) float64, where these are.
    normals : (e, 3) float64, unit normals of the surface along them.
    """

    ends: Indices
    points: Floats
    normals: Floats

    def joined(self, other: "Edges") -> "Edges":
        """These and others."""
        pairs = zip((self.ends, self.points, self.normals), (other.ends, other.points, other.normals), strict=True)
        return Edges(*(np.concatenate(pair) for pair in pairs))

    def crossed_by(self, other: "Edges") -> bool:
        """Whether a single edge crosses one of these, of the same sheet and without an end in common."""
        normal, (begin, end) = other.normals[0], other.points[0]
        along, own = end - begin, self.points[:, 1] - self.points[:, 0]
        across = np.cross(normal, along)
        # Places of the crossing along the other edge (s) and along each of these (t), seen along the normal.
        slope = own @ across
        slope = np.where(slope == 0.0, np.inf, slope)
        t = (begin - self.points[:, 0]) @ across / slope
        there = self.points[:, 0] + t[:, None] * own - begin
        flat = along - normal * (along @ normal)
        s = there @ flat / max(float(flat @ flat), 1e-300)
        gap = np.abs((there - s[:, None] * along) @ normal)
        longer = np.maximum(np.linalg.norm(own, axis=1), np.linalg.norm(along))
        inside = (np.minimum(s, t) > -_TOUCHING) & (np.maximum(s, t) < 1 + _TOUCHING)
        apart = ~np.isin(self.ends, other.ends).any(axis=1)
        return bool(np.any(inside & apart & (self.normals @ normal > 0.0) & (gap <= _NEAR * longer)))

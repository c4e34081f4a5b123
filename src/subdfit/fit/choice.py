"""Which parts the method ``auto`` gives to ``lavoue``: those with many sharp edges."""

from subdfit.fit.lavoue import SCHEMES
from subdfit.fit.settings import FitSettings
from subdfit.target.features import automatic_creases, sharp_share
from subdfit.target.segmentation_noise import noise_of, without_noise
from subdfit.target.target import Target

MOSTLY = 0.5
"""Share of a part's bending in its creases from which its faces and edges make the control mesh. Of parts of planes,
cylinders and sharp edges it is .5 to 1, of scans with a few creases .3 at most."""


def suits_lavoue(target: Target, settings: FitSettings) -> bool:
    """Whether a target bends mostly at its creases, and the settings leave the first control mesh to the method."""
    possible = settings.scheme in SCHEMES and settings.control_vertices is None and not target.cloud
    if not possible or len(target.crease_edges) == 0:
        return False
    points, triangles, creases = target.points, target.triangles, target.crease_edges
    if noise := noise_of(points, triangles, creases):
        # Noise bends every edge, and makes creases of some.
        smooth = without_noise(points, triangles, creases, noise)
        points, triangles = smooth.points, smooth.triangles
        creases = automatic_creases(points, triangles)
    return sharp_share(points, triangles, creases) >= MOSTLY

"""`subdfit.segment`: the faces of a part, and its feature edges."""

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from subdfit.api.lengths import parse_length
from subdfit.api.sources import MeshSource
from subdfit.api.targets import Preparation, prepare
from subdfit.api.workers import workers
from subdfit.errors import InputError
from subdfit.mesh.data import MeshData
from subdfit.target.segmentation import SegmentationSettings, segment_mesh
from subdfit.target.target import Creases


@dataclass(frozen=True, eq=False)
class Segmentation:
    """A mesh whose triangles know to which face of the part they belong.

    Attributes
    ----------
    points : (n, 3) float64, in the caller's unit.
    triangles : (m, 3) int32.
    labels : (m,) int64, 0 to `count` - 1.
    feature_edges : (c, 2) int64, rows of `points`: the sharp edges.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    labels: NDArray[np.int64]
    feature_edges: NDArray[np.int64]

    @property
    def count(self) -> int:
        """Number of faces of the part."""
        return int(self.labels.max()) + 1

    def to_data(self) -> MeshData:
        """Plain arrays, as the PLY writer takes them: labels with the faces, feature edges as creases."""
        return MeshData(
            points=self.points,
            face_offsets=3 * np.arange(len(self.triangles) + 1),
            face_vertices=self.triangles.ravel().astype(np.int64),
            crease_edges=self.feature_edges,
            crease_sharpness=np.full(len(self.feature_edges), np.inf),
            face_labels=self.labels,
        )

    def picture(self, path: str | os.PathLike[str], title: str = "") -> None:
        """Write a PNG of the part from four sides, each face in a colour of its own, feature edges drawn.

        Raises
        ------
        MachineError
            The file cannot be written.
        """
        from subdfit.draw.region_picture import region_picture

        region_picture(os.fspath(path), self.points, self.triangles, self.labels, self.feature_edges, title=title)


def segment(
    mesh: MeshSource,
    *,
    radius: float | str | None = None,
    least_turn: float = 10.0,
    creases: Creases | str = "auto",
    repair: bool = False,
    keep_components: int | None = None,
    fill_holes: int | None = None,
    threads: int | None = None,
) -> Segmentation:
    """Find the faces of a part: regions of like curvature between sharp edges.

    Parameters
    ----------
    mesh
        A path, arrays, or an object that holds a mesh.
    radius
        Of the balls over which curvature is averaged: a length in the mesh's unit, or a share of its diagonal such as
        ``"2%"``; None takes one and a half median edges. Fillets narrower than that are not told apart.
    least_turn
        Degrees by which neighbouring faces differ at least in how they bend, over the width of the narrower one.
    creases
        ``auto`` takes the creases that the file tags, else edges that are surely sharp; ``none``; or degrees.
    repair, keep_components, fill_holes
        What may be changed, as in `subdfit.fit`.
    threads
        None is one a core. The result does not depend on it.

    Raises
    ------
    InputError
        The mesh cannot be read or mended, has no faces, or an option is out of range.

    Notes
    -----
    After Lavoué, Dupont and Baskurt, A new CAD mesh segmentation method, based on curvature tensor analysis, 2005.
    """
    how = Preparation(creases=creases, repair=repair, keep_components=keep_components, fill_holes=fill_holes)  # type: ignore[arg-type]
    length = parse_length(radius, "radius")
    if not 0 <= least_turn < np.inf:
        raise InputError(f"the least turn is {least_turn} degrees; give 0 or more")
    with workers(threads):
        target = prepare(mesh, how).target
        reach = None if length is None else length.share(target.diagonal) * target.diagonal
        settings = SegmentationSettings(radius=reach, least_turn=least_turn)
        regions = segment_mesh(target, settings, find_creases=how.creases == "auto")
    return Segmentation(target.points, target.triangles, regions.labels, regions.feature_edges)

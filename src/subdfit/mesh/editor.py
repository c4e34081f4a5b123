"""One mutable triangle mesh for thousands of local edits: split, flip; surface points are carried along."""

# mypy: allow-untyped-calls

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh._carry_kernels import follow_division, follow_flips, list_points
from subdfit.mesh._division_kernels import complete_marks, divide_faces, join_sides, place_middles
from subdfit.mesh._editor_input import (
    checked_edges,
    checked_mask,
    checked_rows,
    checked_sharpness,
    checked_triangles,
    first_rows,
    paired_half_edges,
)
from subdfit.mesh._flip_kernels import flip_pairs, flip_sweeps
from subdfit.mesh._ring_kernels import rings, torn_vertex
from subdfit.parallel import map_chunks

REGULAR = 6
REGULAR_ON_BOUNDARY = 4
ANY_RISE = np.iinfo(np.int32).max
CHUNK = 65536


@dataclass(frozen=True)
class Split:
    """What a batch of splits did; new vertex ``first + i`` halves an edge of the mesh before the batch.

    Attributes
    ----------
    first : row of the first new vertex.
    ends : (k, 2) int32, rows of the end vertices of each halved edge.
    half_edges : (k,) int64, one half-edge ``3 * face + slot`` of each in the faces before the batch.
    affected : (a,) int64, rising rows of the old vertices that are corners of a face split in four.
    """

    first: int
    ends: NDArray[np.int32]
    half_edges: NDArray[np.int64]
    affected: NDArray[np.int64]

    @property
    def vertices(self) -> NDArray[np.int64]:
        """Rows of the new vertices, (k,)."""
        return np.arange(self.first, self.first + len(self.ends))


@dataclass(frozen=True)
class Frozen:
    """The mesh at one moment, in arrays of its own.

    Attributes
    ----------
    points : (n, 3) float64; triangles : (m, 3) int32, rows of `points`.
    crease_edges : (e, 2) int32; crease_sharpness : (e,) float64.
    corners : (c,) int64, rising; corner_sharpness : (c,) float64.
    parents : (n, 2) int32; a vertex that halved an edge names that edge's ends, any other names itself twice.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    crease_edges: NDArray[np.int32]
    crease_sharpness: NDArray[np.float64]
    corners: NDArray[np.int64]
    corner_sharpness: NDArray[np.float64]
    parents: NDArray[np.int32]


class MeshEditor:
    """An oriented manifold triangle mesh, open or closed, under edit.

    Old vertices and faces keep their rows; new ones are appended in an order that depends on the mesh and
    the edits alone. A face that is split keeps its row for one of its parts.

    Parameters
    ----------
    points : (n, 3) float64.
    triangles : (m, 3) int, rows of `points`, oriented alike; not written to, as `points`.
    crease_edges : (e, 2) int, edges of the mesh; crease_sharpness : (e,) float64 > 0, default sharp for ever.
    corners : (c,) int, rows of `points`; corner_sharpness : (c,) float64 > 0, default sharp for ever.
    max_turn : degrees; a flip is refused when a new normal turns further from the area vector of its quad,
        which both diagonals share.

    Raises
    ------
    InputError
        When the mesh is not an oriented manifold or a tag names no edge or vertex of it.
    """

    def __init__(
        self,
        points: ArrayLike,
        triangles: ArrayLike,
        *,
        crease_edges: ArrayLike | None = None,
        crease_sharpness: ArrayLike | None = None,
        corners: ArrayLike | None = None,
        corner_sharpness: ArrayLike | None = None,
        max_turn: float = 60.0,
    ) -> None:
        self._points = np.array(points, np.float64, order="C")
        corner_rows = checked_triangles(self._points, np.asarray(triangles))
        n, m = len(self._points), len(corner_rows)
        self._vertices, self._faces = n, m
        self._origin = corner_rows.astype(np.int32).ravel()
        self._twin = paired_half_edges(corner_rows, n)
        self._sharp = np.zeros(3 * m)
        self._corner = np.zeros(n)
        self._out = np.empty(n, np.int32)
        self._degree = np.empty(n, np.int32)
        self._parents = np.repeat(np.arange(n, dtype=np.int32), 2).reshape(n, 2)
        self._touched = np.zeros(n, np.bool_)
        self._cos_turn = float(np.cos(np.radians(max_turn)))
        self._refresh_rings()
        torn = torn_vertex(self._origin, self._twin, self._out, self._degree, n)
        if torn >= 0:
            raise InputError(f"vertex {torn} joins separate fans of triangles: give each fan its own vertex")
        self._set_creases(checked_edges(crease_edges), crease_sharpness)
        self._set_corners(corners, corner_sharpness)
        self._given_valence = self._degree.copy()
        self.carry(np.empty(0, np.int32), np.empty((0, 2)))

    @property
    def points(self) -> NDArray[np.float64]:
        """Copy of the vertex positions, (n, 3)."""
        return self._points[: self._vertices].copy()

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Copy of the corner rows of the faces, (m, 3)."""
        return self._origin[: 3 * self._faces].reshape(-1, 3).copy()

    def place(self, vertices: ArrayLike, positions: ArrayLike) -> None:
        """Move vertices.

        Parameters
        ----------
        vertices : (k,) int rows (or a bool mask of all).
        positions : (k, 3) float64.
        """
        self._points[: self._vertices][np.asarray(vertices)] = positions

    # Splits

    def split_faces(self, mask: ArrayLike) -> Split:
        """Split faces in four and their neighbours in two, so that no crack opens.

        A neighbour with two split edges is itself split in four, and so on (Nishiyama et al. 2008, section 5
        and Figure 3, after Marinov and Kobbelt 2005). Edges are halved at the midpoint; `place` then assigns
        the positions of one subdivision step to ``split.vertices`` and ``split.affected``.

        Parameters
        ----------
        mask : (m,) bool, the faces to split.
        """
        chosen = checked_mask(mask, (self._faces,), "faces to split")
        marked = self._both_sides(np.repeat(chosen, 3))
        complete_marks(self._twin, marked, self._faces)
        return self._split(marked)

    def split_edges(self, edges: ArrayLike) -> Split:
        """Halve edges at their midpoints; a face with one, two or three of them becomes two, three or four.

        Of a face with two of them the quad that remains is cut along its shorter diagonal.

        Parameters
        ----------
        edges : (k, 2) int rows of points, or (m, 3) bool: side s of a face begins at its corner s.
        """
        chosen = np.asarray(edges)
        if chosen.dtype == np.bool_:
            marked = checked_mask(chosen, (self._faces, 3), "sides to split").ravel()
        else:
            marked = np.zeros(3 * self._faces, np.bool_)
            marked[self._sides(checked_edges(chosen), "edge to split")] = True
        return self._split(self._both_sides(marked))

    def _both_sides(self, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
        twin = self._twin[: len(marked)]
        return marked | ((twin >= 0) & marked[twin])

    def _split(self, marked: NDArray[np.bool_]) -> Split:
        n, m = self._vertices, self._faces
        old_twin = self._twin[: 3 * m].copy()
        old_sharp = self._sharp[: 3 * m].copy()
        halved = np.flatnonzero(marked & ((old_twin < 0) | (np.arange(3 * m) < old_twin)))
        vertices, faces = n + len(halved), m + int(marked.sum())
        old, sides = self.triangles, marked.reshape(m, 3)
        self._touched[old[sides.any(axis=1)]] = True
        affected = np.unique(old[sides.all(axis=1)]).astype(np.int64)
        self._reserve(vertices, faces)

        middle = np.full(3 * m, -1, np.int32)
        place_middles(self._origin, self._twin, marked, self._points, n, middle, self._parents)
        pattern = np.zeros(m, np.uint8)
        child, first, second = np.empty(m, np.int32), np.empty(3 * m, np.int32), np.empty(3 * m, np.int32)
        divide_faces(self._origin, self._twin, self._sharp, self._points, marked, middle, pattern, child, first, second)
        join_sides(self._twin, self._sharp, old_twin, old_sharp, marked, first, second)
        self._vertices, self._faces = vertices, faces
        self._corner[n:vertices] = 0.0
        self._given_valence[n:vertices] = 0
        self._touched[n:vertices] = True
        self._refresh_rings()

        def follow(start: int, stop: int) -> None:
            follow_division(self._face, self._uv, pattern, child, start, stop)

        map_chunks(follow, len(self._face), CHUNK)
        return Split(n, self._parents[n:vertices].copy(), halved, affected)

    # Flips

    def flip(self, edges: ArrayLike) -> NDArray[np.bool_]:
        """Flip edges in the given order, each unless it may not; return which were flipped, (k,) bool.

        Refused are: edges of the boundary and creases; an edge whose new ends are joined already; a vertex
        left with fewer than three edges, or with a single triangle between two boundary or crease edges; new
        triangles that turn over (see `max_turn`) or are slivers.

        Parameters
        ----------
        edges : (k, 2) int rows of points.
        """
        pairs = checked_rows(checked_edges(edges), self._vertices, "an edge to flip names vertex")
        log = flip_pairs(pairs, self._cos_turn, *self._flip_state())
        self._follow_flips(log)
        return np.asarray(log[:, 0] >= 0)

    def regularise_connectivity(self, region: ArrayLike | None = None, *, max_sweeps: int = 100) -> int:
        """Flip edges while that lowers the sum R of squared valence defects; return the number of flips.

        R(M) = sum (d(v) - d_opt(v))^2 with d_opt 6, on the boundary 4 (Nishiyama et al. 2008, section 5,
        after Surazhsky and Gotsman 2003); for a tagged corner d_opt is the valence it was given with.

        Parameters
        ----------
        region : (n,) bool; only edges with an end or an opposite vertex in it are flipped. None: all edges.
        max_sweeps : bound on the passes over the edges; each but the first looks near the last flips only.
        """
        return self._sweep(region, angles=False, max_rise=-1, max_sweeps=max_sweeps)

    def improve_angles(
        self, region: ArrayLike | None = None, *, max_rise: int | None = None, max_sweeps: int = 100
    ) -> int:
        """Flip edges while that raises the smallest angle of their two triangles; return the number of flips.

        Parameters
        ----------
        region, max_sweeps : as for `regularise_connectivity`.
        max_rise : the most by which one flip may raise R; None, as in Nishiyama et al. 2008, does not ask.
        """
        bound = ANY_RISE if max_rise is None else max_rise
        return self._sweep(region, angles=True, max_rise=bound, max_sweeps=max_sweeps)

    def irregularity(self) -> int:
        """Return R(M), the sum of squared differences between the valences and the optimal ones."""
        used = self._out[: self._vertices] >= 0
        defect = (self._degree[: self._vertices] - self._optimal_valence())[used].astype(np.int64)
        return int(defect @ defect)

    def _sweep(self, region: ArrayLike | None, *, angles: bool, max_rise: int, max_sweeps: int) -> int:
        n = self._vertices
        where = np.ones(n, np.bool_) if region is None else checked_mask(region, (n,), "vertices of the region")
        optimal, last = self._optimal_valence(), 3 * self._faces
        log = flip_sweeps(last, optimal, where, angles, max_rise, self._cos_turn, max_sweeps, *self._flip_state())
        self._follow_flips(log)
        return len(log)

    def _flip_state(self) -> tuple[NDArray[Any], ...]:
        connectivity = (self._origin, self._twin, self._sharp, self._out, self._degree)
        return (*connectivity, self._points, self._touched)

    def _follow_flips(self, log: NDArray[np.int64]) -> None:
        if len(self._face) == 0 or len(log) == 0:
            return
        head, link = np.empty(self._faces, np.int32), np.empty(len(self._face), np.int32)
        list_points(self._face, head, link)
        follow_flips(self._face, self._uv, self._changed, log, head, link)

    def _optimal_valence(self) -> NDArray[np.int32]:
        n = self._vertices
        on_boundary = (self._out[:n] >= 0) & (self._twin[self._out[:n]] < 0)
        optimal = np.where(on_boundary, REGULAR_ON_BOUNDARY, REGULAR)
        return np.where(self._corner[:n] > 0, self._given_valence[:n], optimal).astype(np.int32)

    # Carried points

    def carry(self, face: ArrayLike, uv: ArrayLike) -> None:
        """Register surface points, in place of any before; every later edit moves them.

        A split keeps a point's place on the flat triangles when new vertices lie at midpoints. A flip keeps
        its place in the quad of the two triangles, flattened to a unit square.

        Parameters
        ----------
        face : (k,) int rows of triangles.
        uv : (k, 2) float64; the weights of the face's corners are ``1 - u - v, u, v``.
        """
        faces, parameters = np.array(face, np.int32), np.array(uv, np.float64, order="C")
        if faces.ndim != 1 or parameters.shape != (len(faces), 2):
            raise InputError(f"{faces.shape} faces carry {parameters.shape} parameters: give (k,) and (k, 2)")
        checked_rows(faces, self._faces, "a carried point names face")
        self._face, self._uv = faces, parameters
        self._changed = np.zeros(len(faces), np.bool_)

    def carried(self) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.bool_]]:
        """Return copies of the carried points' face (k,), uv (k, 2) and changed (k,).

        `changed` marks points whose own face was flipped since `carry`; flips and splits near by alter the
        smooth surface under others too: those have a `touched` vertex among the control points of their patch.
        """
        return self._face.copy(), self._uv.copy(), self._changed.copy()

    # Looking back

    def mark(self) -> None:
        """Forget which vertices were touched."""
        self._touched[:] = False

    def touched(self) -> NDArray[np.bool_]:
        """Return which vertices are new or had a triangle split or flipped since `mark`, (n,) bool."""
        return self._touched[: self._vertices].copy()

    def freeze(self) -> Frozen:
        """Return the mesh as it is now; the editor may go on."""
        origin, twin = self._origin[: 3 * self._faces], self._twin[: 3 * self._faces]
        sides = np.flatnonzero((self._sharp[: len(twin)] > 0) & ((twin < 0) | (np.arange(len(twin)) < twin)))
        ends = np.stack([origin[sides], origin[sides - sides % 3 + (sides + 1) % 3]], axis=1)
        corners = np.flatnonzero(self._corner[: self._vertices])
        return Frozen(
            points=self.points,
            triangles=self.triangles,
            crease_edges=ends,
            crease_sharpness=self._sharp[sides],
            corners=corners,
            corner_sharpness=self._corner[corners],
            parents=self._parents[: self._vertices].copy(),
        )

    # Arrays

    def _reserve(self, vertices: int, faces: int) -> None:
        for name in ("_points", "_corner", "_out", "_degree", "_parents", "_touched", "_given_valence"):
            setattr(self, name, _grown(getattr(self, name), vertices))
        for name in ("_origin", "_twin", "_sharp"):
            setattr(self, name, _grown(getattr(self, name), 3 * faces))

    def _refresh_rings(self) -> None:
        rings(self._origin, self._twin, 3 * self._faces, self._out, self._degree)

    def _sides(self, pairs: NDArray[np.int64], what: str) -> NDArray[np.int64]:
        """One half-edge of each edge that `pairs` names."""
        n, rows = self._vertices, self.triangles.astype(np.int64)
        keys = (rows * n + np.roll(rows, -1, axis=1)).ravel()
        a, b = checked_rows(pairs, n, f"a {what} names vertex").T
        there, back = first_rows(keys, a * n + b), first_rows(keys, b * n + a)
        found = np.where(there >= 0, there, back)
        if (found < 0).any():
            k = found.argmin()
            raise InputError(f"{what} ({a[k]}, {b[k]}) is no edge of the mesh: name two joined vertices")
        return found

    def _set_creases(self, pairs: NDArray[np.int64], sharpness: ArrayLike | None) -> None:
        sides = self._sides(pairs, "crease")
        values = checked_sharpness(sharpness, len(pairs), "crease")
        self._sharp[sides] = values
        inner = self._twin[sides] >= 0
        self._sharp[self._twin[sides[inner]]] = values[inner]

    def _set_corners(self, corners: ArrayLike | None, sharpness: ArrayLike | None) -> None:
        rows = np.asarray([] if corners is None else corners).astype(np.int64).reshape(-1)
        checked_rows(rows, self._vertices, "a corner names vertex")
        self._corner[rows] = checked_sharpness(sharpness, len(rows), "corner")


def _grown(array: NDArray[Any], size: int) -> NDArray[Any]:
    """The array with room for `size` rows, at least doubled when it has to grow."""
    if size <= len(array):
        return array
    bigger = np.empty((max(size, 2 * len(array)), *array.shape[1:]), array.dtype)
    bigger[: len(array)] = array
    return bigger

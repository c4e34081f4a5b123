"""One mutable triangle mesh for thousands of local edits: split, flip; surface points are carried along."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.mesh import _editor_kernels as kernels
from subdfit.mesh.data import SHARP_FOR_EVER
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
        corner_rows = _checked_triangles(self._points, np.asarray(triangles))
        n, m = len(self._points), len(corner_rows)
        self._vertices, self._faces = n, m
        self._origin = corner_rows.astype(np.int32).ravel()
        self._twin = _twins(corner_rows, n)
        self._sharp = np.zeros(3 * m)
        self._corner = np.zeros(n)
        self._out = np.empty(n, np.int32)
        self._degree = np.empty(n, np.int32)
        self._parents = np.repeat(np.arange(n, dtype=np.int32), 2).reshape(n, 2)
        self._touched = np.zeros(n, np.bool_)
        self._cos_turn = float(np.cos(np.radians(max_turn)))
        self._refresh_rings()
        torn = kernels.torn_vertex(self._origin, self._twin, self._out, self._degree, n)
        if torn >= 0:
            raise InputError(f"vertex {torn} joins separate fans of triangles: give each fan its own vertex")
        self._set_creases(_pairs(crease_edges), crease_sharpness)
        self._set_corners(corners, corner_sharpness)
        self._given_valence = self._degree.copy()
        self.carry(np.empty(0, np.int32), np.empty((0, 2)))

    @property
    def points(self) -> NDArray[np.float64]:
        """Vertex positions, (n, 3), a read-only view until the next split."""
        view = self._points[: self._vertices]
        view.flags.writeable = False
        return view

    @property
    def triangles(self) -> NDArray[np.int32]:
        """Corner rows of the faces, (m, 3), a read-only view until the next edit."""
        view = self._origin[: 3 * self._faces].reshape(-1, 3)
        view.flags.writeable = False
        return view

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
        chosen = np.asarray(mask)
        if chosen.dtype != np.bool_ or chosen.shape != (self._faces,):
            raise InputError(f"the mask of faces has shape {chosen.shape}: give {self._faces} booleans")
        marked = self._both_sides(np.repeat(chosen, 3))
        kernels.complete_marks(self._twin, marked, self._faces)
        return self._split(marked)

    def split_edges(self, edges: ArrayLike) -> Split:
        """Halve edges at their midpoints; a face with one, two or three of them becomes two, three or four.

        Of a face with two of them the quad that remains is cut along its shorter diagonal.

        Parameters
        ----------
        edges : (k, 2) int rows of points, or (m, 3) bool: side s of a face runs from its corner s to the next.
        """
        chosen = np.asarray(edges)
        if chosen.dtype == np.bool_:
            if chosen.shape != (self._faces, 3):
                raise InputError(f"the mask of sides has shape {chosen.shape}: give ({self._faces}, 3) booleans")
            return self._split(self._both_sides(chosen.ravel()))
        marked = np.zeros(3 * self._faces, np.bool_)
        marked[self._sides(_pairs(chosen), "edge to split")] = True
        return self._split(self._both_sides(marked))

    def _both_sides(self, marked: NDArray[np.bool_]) -> NDArray[np.bool_]:
        twin = self._twin[: len(marked)]
        return marked | ((twin >= 0) & marked[twin])

    def _split(self, marked: NDArray[np.bool_]) -> Split:
        n, m = self._vertices, self._faces
        old_twin = self._twin[: 3 * m].copy()
        old_sharp = self._sharp[: 3 * m].copy()
        halved = np.flatnonzero(marked & ((old_twin < 0) | (np.arange(3 * m) < old_twin)))
        in_faces = marked.reshape(m, 3)
        self._touched[self.triangles[in_faces.any(axis=1)]] = True
        affected = np.unique(self.triangles[in_faces.all(axis=1)]).astype(np.int64)
        self._reserve(n + len(halved), m + int(marked.sum()))

        middle = np.full(3 * m, -1, np.int32)
        kernels.place_middles(self._origin, self._twin, marked, self._points, n, middle, self._parents)
        pattern = np.zeros(m, np.uint8)
        child, first, second = np.empty(m, np.int32), np.empty(3 * m, np.int32), np.empty(3 * m, np.int32)
        kernels.divide_faces(
            self._origin, self._twin, self._sharp, self._points, marked, middle, pattern, child, first, second
        )
        kernels.join_sides(self._twin, self._sharp, old_twin, old_sharp, marked, first, second)
        self._vertices, self._faces = n + len(halved), m + int(marked.sum())
        self._corner[n : self._vertices] = 0.0
        self._given_valence[n : self._vertices] = 0
        self._touched[n : self._vertices] = True
        self._refresh_rings()
        self._in_chunks(lambda i, j: kernels.follow_division(self._face, self._uv, pattern, child, i, j))
        return Split(n, self._parents[n : self._vertices].copy(), halved, affected)

    # Flips

    def flip(self, edges: ArrayLike) -> NDArray[np.bool_]:
        """Flip edges in the given order, each unless it may not; return which were flipped, (k,) bool.

        Refused are: edges of the boundary and creases; an edge whose new ends are joined already; a vertex left
        with fewer than three edges, or with a single triangle between two boundary or crease edges; new
        triangles that turn over (see `max_turn`) or are slivers.

        Parameters
        ----------
        edges : (k, 2) int rows of points.
        """
        pairs = _pairs(edges)
        if len(pairs) and not (0 <= pairs.min() and pairs.max() < self._vertices):
            raise InputError(f"an edge to flip names vertex {pairs.max()} of {self._vertices}: give rows of points")
        flipped: NDArray[np.bool_] = kernels.flip_pairs(*self._flip_state(), pairs, self._cos_turn)
        return flipped

    def regularise_connectivity(self, region: ArrayLike | None = None, *, max_sweeps: int = 100) -> int:
        """Flip edges while that lowers the sum R of squared valence defects; return the number of flips.

        R(M) = sum (d(v) - d_opt(v))^2 with d_opt 6, on the boundary 4 (Nishiyama et al. 2008, section 5, after
        Surazhsky and Gotsman 2003); a tagged corner keeps the valence it was given with.

        Parameters
        ----------
        region : (n,) bool; only edges of which an end or an opposite vertex lies in it are flipped. None: all.
        max_sweeps : bound on the passes over the edges; each after the first looks near the last flips only.
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
        return self._sweep(
            region, angles=True, max_rise=ANY_RISE if max_rise is None else max_rise, max_sweeps=max_sweeps
        )

    def irregularity(self) -> int:
        """Return R(M), the sum of squared differences between the valences and the optimal ones."""
        used = self._out[: self._vertices] >= 0
        defect = (self._degree[: self._vertices] - self._optimal_valence())[used].astype(np.int64)
        return int(defect @ defect)

    def _sweep(self, region: ArrayLike | None, *, angles: bool, max_rise: int, max_sweeps: int) -> int:
        where = np.ones(self._vertices, np.bool_) if region is None else np.ascontiguousarray(region)
        if where.dtype != np.bool_ or where.shape != (self._vertices,):
            raise InputError(f"the region has shape {where.shape}: give {self._vertices} booleans, one a vertex")
        return int(
            kernels.flip_sweeps(
                *self._flip_state(),
                self._optimal_valence(),
                where,
                3 * self._faces,
                angles,
                max_rise,
                self._cos_turn,
                max_sweeps,
            )
        )

    def _flip_state(self) -> tuple[NDArray[Any], ...]:
        head, link = np.empty(self._faces, np.int32), np.empty(len(self._face), np.int32)
        kernels.list_points(self._face, head, link)
        mesh = (self._origin, self._twin, self._sharp, self._out, self._degree, self._points, self._touched)
        return (*mesh, self._face, self._uv, self._changed, head, link)

    def _optimal_valence(self) -> NDArray[np.int32]:
        n = self._vertices
        on_boundary = (self._out[:n] >= 0) & (self._twin[self._out[:n]] < 0)
        optimal = np.where(on_boundary, REGULAR_ON_BOUNDARY, REGULAR)
        return np.where(self._corner[:n] > 0, self._given_valence[:n], optimal).astype(np.int32)

    # Carried points

    def carry(self, face: ArrayLike, uv: ArrayLike) -> None:
        """Register surface points, in place of any before; every later edit moves them.

        A split keeps a point's place on the flat triangles when new vertices lie at midpoints. A flip keeps its
        place in the quad of the two triangles, flattened to a unit square.

        Parameters
        ----------
        face : (k,) int rows of triangles.
        uv : (k, 2) float64; the weights of the face's corners are ``1 - u - v, u, v``.
        """
        faces, parameters = np.array(face, np.int32), np.array(uv, np.float64, order="C")
        if faces.ndim != 1 or parameters.shape != (len(faces), 2):
            raise InputError(f"carried points have {faces.shape} faces and {parameters.shape} uv: give (k,) and (k, 2)")
        if len(faces) and not (0 <= faces.min() and faces.max() < self._faces):
            raise InputError(f"a carried point names face {faces.max()} of {self._faces}: give rows of triangles")
        self._face, self._uv = faces, parameters
        self._changed = np.zeros(len(faces), np.bool_)

    def carried(self) -> tuple[NDArray[np.int32], NDArray[np.float64], NDArray[np.bool_]]:
        """Return copies of the carried points' face (k,), uv (k, 2), and changed (k,): whether a flip moved it."""
        return self._face.copy(), self._uv.copy(), self._changed.copy()

    def _in_chunks(self, job: Callable[[int, int], None]) -> None:
        map_chunks(job, len(self._face), CHUNK)

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
            points=self.points.copy(),
            triangles=self.triangles.copy(),
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
        kernels.rings(self._origin, self._twin, 3 * self._faces, self._out, self._degree)

    def _sides(self, pairs: NDArray[np.int64], what: str) -> NDArray[np.int64]:
        """One half-edge of each edge that `pairs` names."""
        rows = self.triangles
        keys = rows.astype(np.int64) * self._vertices + np.roll(rows, -1, axis=1)
        order = np.argsort(keys, axis=None)
        in_order = keys.ravel()[order]
        found = np.full(len(pairs), -1)
        for a, b in ((pairs[:, 1], pairs[:, 0]), (pairs[:, 0], pairs[:, 1])):
            at = np.minimum(np.searchsorted(in_order, a * self._vertices + b), len(order) - 1)
            inside = (pairs >= 0).all(axis=1) & (pairs < self._vertices).all(axis=1)
            found = np.where(inside & (in_order[at] == a * self._vertices + b), order[at], found)
        if (found < 0).any():
            a, b = pairs[np.argmin(found)]
            raise InputError(f"{what} ({a}, {b}) is not an edge of the mesh: name two vertices of one triangle")
        return found

    def _set_creases(self, pairs: NDArray[np.int64], sharpness: ArrayLike | None) -> None:
        sides = self._sides(pairs, "crease")
        values = _sharpness(sharpness, len(pairs), "crease")
        self._sharp[sides] = values
        inner = self._twin[sides] >= 0
        self._sharp[self._twin[sides[inner]]] = values[inner]

    def _set_corners(self, corners: ArrayLike | None, sharpness: ArrayLike | None) -> None:
        rows = np.asarray([] if corners is None else corners).astype(np.int64).reshape(-1)
        if len(rows) and not (0 <= rows.min() and rows.max() < self._vertices):
            raise InputError(f"a corner names vertex {rows.max()} of {self._vertices}: give rows of points")
        self._corner[rows] = _sharpness(sharpness, len(rows), "corner")


def _checked_triangles(points: NDArray[np.float64], triangles: NDArray[Any]) -> NDArray[np.int64]:
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise InputError(f"the points have shape {points.shape} or are not finite: give (n, 3) finite numbers")
    if triangles.ndim != 2 or triangles.shape[1] != 3 or not np.issubdtype(triangles.dtype, np.integer):
        raise InputError(f"the triangles have shape {triangles.shape}: give (m, 3) integers")
    if len(triangles) == 0:
        raise InputError("the mesh has no triangles: give one at least")
    rows = triangles.astype(np.int64)
    if rows.min() < 0 or rows.max() >= len(points):
        raise InputError(f"a triangle names a vertex outside 0 to {len(points) - 1}: give rows of points")
    repeated = (rows == np.roll(rows, -1, axis=1)).any(axis=1)
    if repeated.any():
        raise InputError(f"triangle {repeated.argmax()} repeats a vertex: remove it")
    return rows


def _twins(triangles: NDArray[np.int64], vertices: int) -> NDArray[np.int32]:
    """Opposite half-edge of each, -1 on the boundary."""
    a, b = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    keys = a * vertices + b
    order = np.argsort(keys)
    in_order = keys[order]
    again = np.flatnonzero(in_order[1:] == in_order[:-1])
    if len(again):
        h = order[again[0]]
        raise InputError(
            f"edge ({a[h]}, {b[h]}) runs the same way in two triangles: orient them alike, two to an edge"
        )
    wanted = b * vertices + a
    at = np.minimum(np.searchsorted(in_order, wanted), len(order) - 1)
    twin = np.where(in_order[at] == wanted, order[at], -1)
    apex = np.roll(triangles, 1, axis=1).ravel()
    same = (twin >= 0) & (apex == apex[twin])
    if same.any():
        h = int(same.argmax())
        raise InputError(f"triangles {h // 3} and {twin[h] // 3} have the same corners: remove one")
    return twin.astype(np.int32)


def _pairs(edges: ArrayLike | None) -> NDArray[np.int64]:
    pairs = np.empty((0, 2), np.int64) if edges is None else np.asarray(edges)
    if len(pairs) == 0:
        return np.empty((0, 2), np.int64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or not np.issubdtype(pairs.dtype, np.integer):
        raise InputError(f"the edges have shape {pairs.shape}: give (k, 2) integers, rows of points")
    return np.ascontiguousarray(pairs, np.int64)


def _sharpness(sharpness: ArrayLike | None, count: int, what: str) -> NDArray[np.float64]:
    if sharpness is None:
        return np.full(count, SHARP_FOR_EVER)
    values = np.asarray(sharpness, np.float64)
    if values.shape != (count,) or not (values > 0).all():
        raise InputError(f"{what} sharpness has shape {values.shape}: give {count} numbers above 0")
    return values


def _grown(array: NDArray[Any], size: int) -> NDArray[Any]:
    """The array with room for `size` rows, at least doubled when it has to grow."""
    if size <= len(array):
        return array
    bigger = np.empty((max(size, 2 * len(array)), *array.shape[1:]), array.dtype)
    bigger[: len(array)] = array
    return bigger

"""What of an imperfect mesh is mended, and what is refused."""

import logging
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from subdfit.errors import InputError
from subdfit.mesh._polygons import Edges, Indices, Polygons, edges_of
from subdfit.mesh._repair_kernels import merge_labels
from subdfit.mesh._sheets import match_crowded, orientation, split_fans, twist_cut
from subdfit.mesh._slivers import remove_slivers, without_area
from subdfit.mesh.data import MeshData
from subdfit.wording import counted

logger = logging.getLogger(__name__)

_LARGEST = 1e100  # squares and cubes of coordinates must stay finite


@dataclass(frozen=True)
class Mended:
    """A mesh that is manifold and consistently oriented, without isolated vertices or faces without area.

    Attributes
    ----------
    data : the mesh.
    vertex_rows : (n,) int64, the row in the original mesh of each vertex.
    messages : what was mended, a line each.
    """

    data: MeshData
    vertex_rows: NDArray[np.int64]
    messages: tuple[str, ...]


def check(data: MeshData, name: str = "mesh") -> None:
    """Refuse what nothing can mend.

    Raises
    ------
    InputError
        There are no points, they are complex, a coordinate is not finite (or so large that its square is not), a face,
        crease or corner names a vertex that does not exist, a sharpness is no number from 0 on, or normals are not one
        a point.
    """
    count = len(data.points)
    if count == 0:
        raise InputError(f"{name}: has no points; export it again")
    if np.iscomplexobj(data.points):
        raise InputError(f"{name}: its points are complex numbers; give real ones")
    fine = np.abs(data.points) < _LARGEST
    if not fine.all():
        bad = np.flatnonzero(~fine.all(axis=1))
        place = " ".join(f"{x:g}" for x in data.points[bad[0]])
        raise InputError(
            f"{name}: {counted(len(bad), 'point is', 'points are')} not finite or too large, the first is row {bad[0]} "
            f"({place}); remove or correct them"
        )
    if data.normals is not None and data.normals.shape != data.points.shape:
        raise InputError(
            f"{name}: has {counted(len(data.normals), 'normal')} for {counted(count, 'point')}; give one each, or none"
        )
    _check_rows(data.face_vertices, count, name, "corner", "faces")
    _check_rows(data.crease_edges.ravel(), count, name, "end", "creases")
    _check_rows(data.corner_vertices, count, name, "entry", "corners")
    for sharpness in (data.crease_sharpness, data.corner_sharpness):
        if len(sharpness) and not (sharpness >= 0).all():
            worst = sharpness[~(sharpness >= 0)][0]
            raise InputError(f"{name}: a sharpness is {worst:g}; it must be 0 or more, 10 is sharp for ever")


def _check_rows(rows: Indices, count: int, name: str, part: str, whole: str) -> None:
    if len(rows) and (rows.min() < 0 or rows.max() >= count):
        bad = np.flatnonzero((rows < 0) | (rows >= count))
        raise InputError(
            f"{name}: {part} {bad[0]} of the {whole} names vertex {rows[bad[0]]}, there are {count} (rows from 0); "
            "export it again"
        )


def mend(data: MeshData, *, repair: bool = False, name: str = "mesh") -> Mended:
    """Mend what can be mended without a choice of shape, refuse the rest; each mending is one warning that counts.

    Mended are: isolated vertices; repeated positions, where merging them joins a soup of faces to a surface; faces
    that repeat a vertex; faces that are there twice; faces without area; disagreeing orientation (the fewer faces of
    a component are turned); vertices that join separate fans of faces (a copy for each).

    Parameters
    ----------
    data
        Polygons as read; bare points are only checked.
    repair
        Also cut apart the sheets at edges with more than two faces, and surfaces that cannot be oriented.
    name
        What messages call the mesh.

    Raises
    ------
    InputError
        As `check`; or, unless `repair`, for edges with more than two faces and surfaces that cannot be oriented;
        or nothing is left.
    """
    check(data, name)
    if data.face_count == 0:
        return Mended(data, np.arange(len(data.points)), ())
    bench = _Bench(data, name)
    bench.count_isolated()
    bench.merge_soup()
    bench.drop_repeats()
    bench.drop_duplicates()
    bench.take_out_slivers()
    bench.part_crowded_edges(repair)
    bench.orient(repair)
    bench.split_vertices()
    return bench.finish()


class _Bench:
    """A mesh under repair: its faces change, rows of vertices only grow until `finish`."""

    def __init__(self, data: MeshData, name: str) -> None:
        self.data, self.name = data, name
        self.faces = Polygons(data.face_offsets.astype(np.int64), data.face_vertices.astype(np.int64))
        self.origin = np.arange(len(data.points))  # original row of each current one
        self.merged = np.arange(len(data.points))  # original row that an original row was merged into
        self.messages: list[str] = []
        self._edges: Edges | None = None

    @property
    def edges(self) -> Edges:
        """How the current faces meet."""
        if self._edges is None:
            self._edges = edges_of(self.faces)
        return self._edges

    def _set(self, faces: Polygons) -> None:
        self.faces, self._edges = faces, None

    def _say(self, count: int, one: str, many: str, deed: str) -> None:
        if count:
            message = f"{counted(count, one, many)} {deed}"
            self.messages.append(message)
            logger.warning("%s: %s", self.name, message)

    def count_isolated(self) -> None:
        """Tell of vertices without a face; `finish` leaves them out."""
        isolated = int((np.bincount(self.faces.corners, minlength=len(self.origin)) == 0).sum())
        self._say(isolated, "isolated vertex", "isolated vertices", "left out")

    def merge_soup(self) -> None:
        """Merge boundary vertices at one position, if that makes a surface of a soup of pieces.

        It does when the faces hang together by nothing else; or when most boundary edges find their other side, as a
        rule on another piece, and no edge gets a third face. A surface that merely touches itself stays as it is.
        """
        faces, now = self.faces, self.edges
        rim = np.unique(np.concatenate((faces.corners[now.boundary], faces.heads[now.boundary])))
        merged = self.merged.copy()
        merged[rim] = _first_at_same_position(self.data.points, rim)
        count = int((merged != self.merged).sum())
        if count == 0:
            return
        joined = Polygons(faces.offsets, merged[faces.corners])
        then = edges_of(joined)
        gain = len(now.boundary) - len(then.boundary)
        pieces = merge_labels(faces.face[now.first], faces.face[now.second], faces.count)
        between = np.count_nonzero(pieces[faces.face[then.first]] != pieces[faces.face[then.second]])
        loose = len(now.boundary) == len(faces.corners)
        seams = 2 * gain >= len(now.boundary) and 4 * between >= gain and len(then.crowded) <= len(now.crowded)
        if gain > 0 and (loose or seams):
            self.merged = merged
            self._set(joined)
            self._say(count, "repeated position", "repeated positions", "of a soup of faces merged")

    def drop_repeats(self) -> None:
        """Cut faces that repeat a vertex into loops that do not, and drop loops of one or two corners."""
        bad = self.faces.sizes < 3
        for rows, corners in self.faces.by_size():
            ordered = np.sort(corners, axis=1)
            for i in range(1, corners.shape[1]):
                bad[rows] |= ordered[:, i] == ordered[:, i - 1]
        if not bad.any():
            return
        bounds = self.faces.offsets
        loops = [
            loop
            for row in np.flatnonzero(bad).tolist()
            for loop in _simple_loops(self.faces.corners[bounds[row] : bounds[row + 1]].tolist())
        ]
        self._set(self.faces.select(~bad).extend(loops))
        deed = f"taken out ({len(loops)} kept without the repeat)" if loops else "taken out"
        self._say(int(bad.sum()), "face that repeats a vertex", "faces that repeat a vertex", deed)

    def drop_duplicates(self) -> None:
        """Keep one of the faces with the same corners in the same order.

        Of two that run opposite ways one goes too, if that frees all edges of a third face; else they may be the two
        sides of a thin sheet, which stay.
        """
        before = self.faces.count
        if _first_of_each(self.faces, turned_too=True).all():
            return
        first = _first_of_each(self.faces, turned_too=False)
        if not first.all():
            self._set(self.faces.select(first))
        crowded = np.zeros(self.faces.count, np.bool_)
        crowded[self.faces.face[np.concatenate([np.empty(0, np.int64), *self.edges.crowded])]] = True
        single = self.faces.select(_first_of_each(self.faces, turned_too=True) | ~crowded)
        if single.count < self.faces.count and not edges_of(single).crowded:
            self._set(single)
        self._say(before - self.faces.count, "duplicate face", "duplicate faces", "taken out")

    def take_out_slivers(self) -> None:
        """Take out faces without area."""
        flat = without_area(self.faces, self.data.points)
        if not flat.any():
            return
        faces, merged, (collapsed, given, dropped) = remove_slivers(self.faces, self.data.points, flat)
        self.merged = merged[self.merged]
        self._set(faces)
        deed = f"taken out ({counted(collapsed, 'edge')} collapsed, {given} merged with a neighbour, {dropped} dropped)"
        self._say(int(flat.sum()), "zero-area face", "zero-area faces", deed)

    def part_crowded_edges(self, repair: bool) -> None:
        """Leave at most two faces an edge, or refuse."""
        crowded = self.edges.crowded
        if not crowded:
            return
        edge = self._edge_name(crowded[0][0])
        if not repair:
            raise InputError(
                f"{self.name}: {counted(len(crowded), 'edge has', 'edges have')} more than two faces, the first is "
                f"{edge} with {len(crowded[0])}; repair=True (--repair of fit, measure and segment) cuts them apart"
            )
        found = self.edges.first, self.edges.second
        matched = match_crowded(self.faces, self.edges, self.data.points[self.origin])
        before = self.faces, self.origin
        self._split((np.concatenate((found[0], matched[0])), np.concatenate((found[1], matched[1]))))
        if self.edges.crowded:  # a fan passed an edge twice: open these edges altogether
            (faces, self.origin) = before
            self._set(faces)
            self._split(found)
        self._say(len(crowded), "edge with more than two faces", "edges with more than two faces", "cut apart")

    def orient(self, repair: bool) -> None:
        """Make neighbours agree, or refuse; `repair` cuts a one-sided surface where it closes on itself."""
        edges = self.edges
        if not (self.faces.corners[edges.first] == self.faces.corners[edges.second]).any():
            return
        turned, twisted = orientation(self.faces, edges)
        if twisted.any():
            tree_turned, cut = twist_cut(self.faces, edges, twisted)
            if not repair:
                raise InputError(
                    f"{self.name}: the surface cannot be oriented, following it round through edge "
                    f"{self._edge_name(edges.first[cut][0])} turns it over; "
                    "repair=True (--repair of fit, measure and segment) cuts it open"
                )
            turned = np.where(twisted, tree_turned, turned)
            self._split((edges.first[~cut], edges.second[~cut]))
            count = int(cut.sum())
            self._say(count, "edge of a one-sided surface", "edges of a one-sided surface", "cut open")
        self._set(self.faces.turn(turned))
        self._say(int(turned.sum()), "face", "faces", "turned to agree with the rest")

    def split_vertices(self) -> None:
        """Give separate fans of faces a vertex each."""
        copied = self._split((self.edges.first, self.edges.second))
        count = len(np.unique(copied))
        self._say(count, "vertex shared by separate fans", "vertices shared by separate fans", "split")

    def _split(self, pairs: tuple[Indices, Indices]) -> Indices:
        faces, copied = split_fans(self.faces, pairs, len(self.origin))
        if len(copied):
            self._set(faces)
            self.origin = np.concatenate((self.origin, self.origin[copied]))
        return copied

    def _edge_name(self, half_edge: int) -> str:
        ends = sorted(self.origin[[self.faces.corners[half_edge], self.faces.heads[half_edge]]].tolist())
        return f"({ends[0]}, {ends[1]})"

    def finish(self) -> Mended:
        """Drop unused rows and carry creases, corners and normals over."""
        if self.faces.count == 0:
            raise InputError(f"{self.name}: no face with an area is left; export it again, or its points alone")
        used = np.bincount(self.faces.corners, minlength=len(self.origin)) > 0
        rows = self.origin[used]
        corners = (np.cumsum(used) - 1)[self.faces.corners]
        faces = Polygons(self.faces.offsets, corners)
        crease_edges, crease_sharpness = self._creases(faces, rows)
        sharp, corner_sharpness = self._corners(rows)
        data = replace(
            self.data,
            points=self.data.points[rows],
            face_offsets=faces.offsets,
            face_vertices=corners,
            crease_edges=crease_edges,
            crease_sharpness=crease_sharpness,
            corner_vertices=sharp,
            corner_sharpness=corner_sharpness,
            normals=None if self.data.normals is None else self.data.normals[rows],
        )
        return Mended(data, rows, tuple(self.messages))

    def _creases(self, faces: Polygons, rows: Indices) -> tuple[Indices, NDArray[np.float64]]:
        """Give every edge between copies of a crease's ends its sharpness; tell of creases that are no edge."""
        ends = self.merged[self.data.crease_edges]
        sharpness = self.data.crease_sharpness[ends[:, 0] != ends[:, 1]]
        ends = np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1)
        if not len(ends):
            return ends, sharpness
        edges = edges_of(faces)
        half_edges = np.concatenate((edges.first, edges.boundary))
        pairs = np.stack((faces.corners[half_edges], faces.heads[half_edges]), axis=1)
        origins = np.sort(rows[pairs], axis=1)
        count = len(self.data.points)
        wanted = ends[:, 0] * count + ends[:, 1]
        present = origins[:, 0] * count + origins[:, 1]
        unique, inverse = np.unique(wanted, return_inverse=True)
        sharpest = np.zeros(len(unique))
        np.maximum.at(sharpest, inverse, sharpness)
        self._say(
            int((~np.isin(wanted, present)).sum()), "crease that is no edge", "creases that are no edges", "left out"
        )
        found = np.flatnonzero(np.isin(present, unique))
        found = found[np.argsort(half_edges[found], kind="stable")]
        return np.sort(pairs[found], axis=1), sharpest[np.searchsorted(unique, present[found])]

    def _corners(self, rows: Indices) -> tuple[Indices, NDArray[np.float64]]:
        sharpness = np.zeros(len(self.data.points))
        np.maximum.at(sharpness, self.merged[self.data.corner_vertices], self.data.corner_sharpness)
        sharp = np.flatnonzero(sharpness[rows])
        return sharp, sharpness[rows[sharp]]


def _first_at_same_position(points: NDArray[np.float64], rows: Indices) -> Indices:
    """For each of `rows` the lowest of them at exactly its position."""
    if not len(rows):
        return rows
    places = points[rows] + 0.0  # -0 and 0 are one place
    order = np.lexsort((places[:, 2], places[:, 1], places[:, 0]))  # stable: lowest row first
    ordered = places[order]
    new = np.concatenate(([True], (ordered[1:] != ordered[:-1]).any(axis=1)))
    first = np.empty(len(rows), np.int64)
    first[order] = rows[order[np.flatnonzero(new)[np.cumsum(new) - 1]]]
    return first


def _simple_loops(corners: list[int]) -> list[list[int]]:
    """Cut a closed walk at repeated vertices; only loops of three corners and more enclose anything."""
    loops, path, place = list[list[int]](), list[int](), dict[int, int]()
    for v in corners:
        if v in place:
            start = place[v]
            loops.append(path[start:])
            for gone in path[start:]:
                del place[gone]
            del path[start:]
        place[v] = len(path)
        path.append(v)
    return [loop for loop in [*loops, path] if len(loop) > 2]


def _first_of_each(faces: Polygons, *, turned_too: bool) -> NDArray[np.bool_]:
    """Mark the first of faces with the same corners in the same cyclic order, or (`turned_too`) in the opposite one."""
    first = np.ones(faces.count, np.bool_)
    for rows, corners in faces.by_size():
        alike = np.flatnonzero(_maybe_repeated(corners))
        if not len(alike):
            continue
        keys = _canonical(corners[alike], turned_too)
        order = np.lexsort(keys.T[::-1])
        ordered = keys[order]
        repeat = (ordered[1:] == ordered[:-1]).all(axis=1)
        first[rows[alike[order[1:][repeat]]]] = False
    return first


def _maybe_repeated(corners: Indices) -> NDArray[np.bool_]:
    """Mark rows whose corners, in any order, have a hash that another row has too."""
    mixed = (corners.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    hashes = mixed[:, 0].copy()
    for column in range(1, corners.shape[1]):
        hashes += mixed[:, column]
    ordered = np.sort(hashes)
    repeated = np.unique(ordered[1:][ordered[1:] == ordered[:-1]])
    if not len(repeated):
        return np.zeros(len(corners), np.bool_)
    slot = np.minimum(np.searchsorted(repeated, hashes), len(repeated) - 1)
    found: NDArray[np.bool_] = repeated[slot] == hashes
    return found


def _canonical(corners: Indices, turned_too: bool) -> Indices:
    """Turn each row (m, k) to start at its lowest vertex and, if `turned_too`, go on with the lower neighbour."""
    size = corners.shape[1]
    start = np.argmin(corners, axis=1)[:, None]
    ahead = np.take_along_axis(corners, (start + np.arange(size)) % size, axis=1)
    if not turned_too:
        return ahead
    back = np.take_along_axis(corners, (start - np.arange(size)) % size, axis=1)
    return np.where((ahead[:, 1] <= back[:, 1])[:, None], ahead, back)

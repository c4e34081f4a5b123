"""The limit surface of a control mesh under a scheme: linear in the control points, exact everywhere."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from subdfit.errors import InputError
from subdfit.limit import _kernels as kernels
from subdfit.limit import _weight_kernels as weight_kernels
from subdfit.limit._locate_kernels import Patches
from subdfit.limit.curvature import PrincipalCurvature, curvature_of_derivatives, undefined, unit
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.parallel import map_chunks
from subdfit.schemes import Scheme, scheme_named
from subdfit.schemes.domain import CORNERS, Domain
from subdfit.schemes.patch_table import AT_ONCE, LEVELS, PatchTable

Floats = NDArray[np.float64]

CHUNK = 16384


class Evaluation(NamedTuple):
    """What `LimitSurface.evaluate` gives; derivatives that were not asked for are None.

    Attributes
    ----------
    position : (k, 3), in the control points' unit.
    first : (k, 2, 3), derivatives by u and v.
    second : (k, 3, 3), derivatives by uu, uv and vv.
    """

    position: Floats
    first: Floats | None
    second: Floats | None


@dataclass(frozen=True, eq=False)
class CompiledTopology:
    """What a scheme makes of a topology, shared by all surfaces over it."""

    scheme: Scheme
    topology: Topology
    domain: Domain

    @classmethod
    def of(cls, scheme: Scheme, topology: Topology) -> "CompiledTopology":
        """The topology's faces; raises InputError where the scheme cannot take it."""
        scheme.validate(topology)
        return cls(scheme, topology, scheme.domain(topology))

    @cached_property
    def table(self) -> PatchTable:
        """Its patches, compiled when they are first asked for: some surfaces are only cut into regions."""
        return self.scheme.patches(self.topology)

    @cached_property
    def local_matrix(self) -> sp.csr_array:
        """Local patch points from control points."""
        return self.table.local_matrix

    @cached_property
    def local_matrix_transposed(self) -> sp.csr_array:
        """Its transpose, by rows."""
        return sp.csr_array(self.local_matrix.T)


class LimitSurface:
    """The limit surface of a control mesh.

    Parameters
    ----------
    control_mesh
        Its control points and connectivity.
    scheme
        A scheme or its name; None takes the mesh's own, else Loop.

    Raises
    ------
    InputError
        The scheme cannot take this connectivity.

    Examples
    --------
    >>> import numpy as np
    >>> octahedron = ControlMesh.from_triangles(
    ...     np.vstack([np.eye(3), -np.eye(3)]),
    ...     [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
    ... )
    >>> surface = LimitSurface(octahedron, "loop")
    >>> surface.evaluate([0], [[1 / 3, 1 / 3]]).position.round(4)
    array([[0.2352, 0.2352, 0.2352]])
    """

    def __init__(self, control_mesh: ControlMesh, scheme: str | Scheme | None = None) -> None:
        chosen = scheme_named(scheme or control_mesh.scheme or "loop")
        self._set(CompiledTopology.of(chosen, control_mesh.topology), control_mesh)

    def _set(self, compiled: CompiledTopology, control_mesh: ControlMesh) -> None:
        self.compiled = compiled
        self.control_mesh = control_mesh

    @property
    def scheme(self) -> Scheme:
        """The subdivision scheme."""
        return self.compiled.scheme

    @property
    def domain(self) -> Domain:
        """The parametric faces."""
        return self.compiled.domain

    @property
    def topology(self) -> Topology:
        """The control mesh's connectivity."""
        return self.control_mesh.topology

    def with_points(self, points: ArrayLike) -> "LimitSurface":
        """Return the surface of the same connectivity with other control points, without compiling it again."""
        other = object.__new__(type(self))
        other._set(self.compiled, self.control_mesh.with_points(points))
        return other

    def with_domain(self, domain: Domain) -> "LimitSurface":
        """Return the same surface, whose cells join as another domain says."""
        other = object.__new__(type(self))
        other._set(replace(self.compiled, domain=domain), self.control_mesh)
        return other

    @cached_property
    def patches(self) -> Patches:
        """The arrays that kernels take."""
        t, control = self.compiled.table, self.control_mesh.points
        positions = np.concatenate([control, self.compiled.local_matrix @ control])
        return Patches(
            self.domain.shape,
            t.cell_node,
            t.node_children,
            t.patch_type,
            t.patch_corner,
            t.patch_offset,
            t.patch_points,
            t.type_size,
            t.type_levels,
            t.type_offset,
            t.type_strips,
            t.matrices,
            t.strips.parts,
            t.strips.sides,
            t.strips.products,
            AT_ONCE,
            t.strips.matrices,
            t.strips.levels,
            t.quad_degree,
            positions,
        )

    def evaluate(self, face: ArrayLike, uv: ArrayLike, derivatives: int = 0) -> Evaluation:
        """Evaluate the surface exactly.

        Parameters
        ----------
        face
            (k,) parametric faces (for Loop, the control mesh's faces).
        uv
            (k, 2) parameters: a triangle's corners are (0, 0), (1, 0), (0, 1), a quad's those of the unit square.
        derivatives
            0, 1 or 2.

        Returns
        -------
        Evaluation
            At an irregular corner itself the scheme's derivatives by u and v vanish or diverge: there `first` holds
            limit tangents along the two edges, and `second` is zero. Towards irregular corners second derivatives grow
            without bound, but for Loop's at inner vertices of three faces; see the user's guide.

            The tangents span the tangent plane, where there is one. Loop's surface has none beside a crease or boundary
            vertex in a sector (between two sharp edges) of six faces or more, nor beside a corner vertex in a sector of
            three or more or with fewer than two sharp edges; along sharp edges the tangents are those of their curves
            even there.

        Raises
        ------
        InputError
            A face that does not exist, parameters outside the face by more than rounding, or another `derivatives`.
        """
        _check_choice(derivatives, "derivatives", 2)
        cell, parameter = self._checked(face, uv)
        order = kernels.order_by_cell(cell, self.domain.face_count)
        position = np.empty((len(cell), 3))
        first = np.empty((len(cell) if derivatives > 0 else 0, 2, 3))
        second = np.empty((len(cell) if derivatives > 1 else 0, 3, 3))

        def job(start: int, stop: int) -> None:
            kernels.evaluate(self.patches, cell, parameter, order, start, stop, derivatives, position, first, second)

        map_chunks(job, len(cell), CHUNK)
        return Evaluation(position, first if derivatives > 0 else None, second if derivatives > 1 else None)

    def patch_weights(
        self, face: NDArray[np.int32], uv: Floats, derivative: int = 0
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], Floats]:
        """Rows of weights over *patch points*, as offsets, columns and values: what `weights` is made of."""
        offsets = weight_kernels.row_sizes(self.patches, face, uv)
        columns = np.empty(offsets[-1], np.int32)
        values = np.empty(offsets[-1])

        def job(start: int, stop: int) -> None:
            weight_kernels.weights(self.patches, face, uv, offsets, start, stop, derivative, columns, values)

        map_chunks(job, len(face), CHUNK)
        return offsets, columns, values

    def weights(self, face: ArrayLike, uv: ArrayLike, derivative: int = 0) -> sp.csr_array:
        """Rows W with ``S(face, uv) = W @ control points``, (k, n) sparse.

        Parameters
        ----------
        face, uv
            As in `evaluate`.
        derivative
            0 for the position, 1 and 2 for the derivatives by u and v, 3 to 5 for those by uu, uv and vv.

        Raises
        ------
        InputError
            As `evaluate`.
        """
        _check_choice(derivative, "derivative", 5)
        cell, parameter = self._checked(face, uv)
        offsets, columns, values = self.patch_weights(cell, parameter, derivative)
        matrix = self.compiled.table.point_matrix
        rows = sp.csr_array((values, columns, offsets), shape=(len(cell), matrix.shape[0]))
        return sp.csr_array(rows @ matrix)

    def normals(self, face: ArrayLike, uv: ArrayLike) -> Floats:
        """Unit normals of the tangents that `evaluate` gives, (k, 3); zero where these are parallel."""
        first = self.evaluate(face, uv, 1).first
        assert first is not None
        return unit(np.cross(first[:, 0], first[:, 1]))

    def curvatures(self, face: ArrayLike, uv: ArrayLike) -> PrincipalCurvature:
        """Principal curvatures and directions, and unit normals.

        Parameters
        ----------
        face, uv
            As in `evaluate`.

        Returns
        -------
        PrincipalCurvature
            ``minimum`` and ``maximum`` (k,), positive where the surface bends away from its normal; their directions
            and the normal, (k, 3) unit vectors.

            All but the normal is nan at irregular corners themselves and where tangents are parallel. Towards such a
            corner curvatures change by mu / lambda^2 with every halving of the distance, lambda the eigenvalue of the
            tangents there and mu the largest that bends the surface: round inner vertices Catmull-Clark's diverge from
            five faces on and tend to zero at three, Loop's diverge from seven on and double each time at three.

        Raises
        ------
        InputError
            As `evaluate`.
        """
        cell, parameter = self._checked(face, uv)
        value = self.evaluate(cell, parameter, 2)
        assert value.first is not None
        assert value.second is not None
        found = curvature_of_derivatives(value.first, value.second)
        return undefined(found, self._in_irregular_corner(cell, parameter))

    def vertex_limits(self) -> Floats:
        """Limit points of the control vertices, (n, 3)."""
        return self.scheme.limit_points(self.topology, self.control_mesh.points)

    def _in_irregular_corner(self, cell: NDArray[np.int32], uv: Floats) -> NDArray[np.bool_]:
        """Whether each parameter is an irregular corner's as `evaluate` sees it, (k,)."""
        corners = CORNERS[self.domain.shape[cell]]
        reach = np.where(self.domain.present[cell], np.abs(corners - uv[:, None]).max(axis=2), np.inf)
        row, corner = np.nonzero(reach < 2.0**-LEVELS)
        t = self.compiled.table
        patch = t.cell_node[cell[row]]
        while (cut := patch < 0).any():
            # The part of a cell at its corner has the corner as its own.
            patch = np.where(cut, t.node_children[np.where(cut, ~patch, 0), corner], patch)
        found = np.zeros(len(cell), np.bool_)
        found[row] = (t.type_levels[t.patch_type[patch]] > 0) & (t.patch_corner[patch] == corner)
        return found

    def _checked(self, face: ArrayLike, uv: ArrayLike) -> tuple[NDArray[np.int32], Floats]:
        given = np.atleast_1d(face)
        parameter = np.ascontiguousarray(_numbers(uv, "parameters")).reshape(-1, 2)
        if given.ndim != 1:
            raise InputError(f"faces have the shape {given.shape}; give (k,)")
        if len(given) != len(parameter):
            raise InputError(f"{len(given)} faces but {len(parameter)} parameter pairs; give one pair a face")
        if len(given) and not np.issubdtype(given.dtype, np.integer):
            raise InputError(f"faces are whole numbers; got {given.dtype}")
        # What does not fit in 32 bits must not become another face.
        within = given if given.dtype == np.int32 else np.clip(given, -1, self.domain.face_count)
        cell = np.ascontiguousarray(within, np.int32)
        bad = kernels.first_outside(cell, parameter, self.domain.shape, 1e-9)
        if bad >= 0:
            raise InputError(f"row {bad}: face {given[bad]} with parameters {parameter[bad]} is not on the surface")
        return cell, parameter


def _check_choice(given: int, name: str, most: int) -> None:
    """Raise InputError unless a number is whole and from 0 to `most`."""
    if isinstance(given, bool) or not isinstance(given, int | np.integer) or not 0 <= given <= most:
        raise InputError(f"{name} is {given!r}; give a whole number from 0 to {most}")


def _numbers(given: ArrayLike, name: str) -> Floats:
    """Pairs of numbers as an array; raises InputError where these are none."""
    try:
        numbers = np.asarray(given, np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name} are no numbers; give an array of shape (k, 2)") from None
    if numbers.size % 2 or (numbers.ndim > 1 and numbers.shape[-1] != 2):
        raise InputError(f"{name} have the shape {numbers.shape}; give (k, 2)")
    return numbers

"""Footpoints by Newton's method on the limit surface, walking from cell to cell."""

from typing import NamedTuple

import numpy as np

from subdfit.compiled import inlined_kernel, kernel
from subdfit.limit._kernels import expand
from subdfit.limit._locate_kernels import QUAD, TRIANGLE
from subdfit.limit._strip_kernels import SLOTS

MAX_CROSSINGS = 16
BACKTRACKS = 8
ON_SIDE = 1e-12
"""Parameters this near a side are on it."""
POSITIVE = 0.05
"""The Hessian counts as positive when its determinant exceeds this share of the metric's."""


class Cells(NamedTuple):
    """The arrays of a `Domain` that walking needs."""

    shape: np.ndarray
    neighbour: np.ndarray
    neighbour_side: np.ndarray
    sharp: np.ndarray


@inlined_kernel
def seen_from_side(shape, side, u, v):  # type: ignore[no-untyped-def]
    """Parameters along and away from a side: s runs from its first corner to its second, t into the cell."""
    if side == 0:
        return u, v
    if shape == QUAD:
        if side == 1:
            return v, 1 - u
        if side == 2:
            return 1 - u, 1 - v
        return 1 - v, u
    if side == 1:
        return v, 1 - u - v
    return 1 - u - v, u


@inlined_kernel
def from_side(shape, side, s, t):  # type: ignore[no-untyped-def]
    """Parameters of a cell from those of `seen_from_side`."""
    if side == 0:
        return s, t
    if shape == QUAD:
        if side == 1:
            return 1 - t, s
        if side == 2:
            return 1 - s, 1 - t
        return t, 1 - s
    if side == 1:
        return 1 - s - t, s
    return t, 1 - s - t


@inlined_kernel
def cross(cells, cell, side, u, v, du, dv):  # type: ignore[no-untyped-def]
    """Continue beyond a side: cells are unfolded as regular parameters are, two triangles to a parallelogram."""
    shape = cells.shape[cell]
    other, j = cells.neighbour[cell, side], cells.neighbour_side[cell, side]
    beyond = cells.shape[other]
    s, t = seen_from_side(shape, side, u, v)
    s1, t1 = seen_from_side(shape, side, u + du, v + dv)
    # A triangle's t leans: it goes half a side back along s for each unit.
    lean = 0.5 * (beyond == TRIANGLE) - 0.5 * (shape == TRIANGLE)
    s, t = 1 - s + lean * t, -t
    s1, t1 = 1 - s1 + lean * t1, -t1
    nu, nv = from_side(beyond, j, s, t)
    eu, ev = from_side(beyond, j, s1, t1)
    return other, nu, nv, eu - nu, ev - nv


@inlined_kernel
def first_side_hit(shape, u, v, du, dv):  # type: ignore[no-untyped-def]
    """Side through which a step leaves a cell, -1 if none, and at which share of the step."""
    side, t = -1, 1.0
    if dv < 0 and v + dv < 0:
        side, t = 0, v / -dv
    if du < 0 and u + du < 0 and u / -du < t:
        side, t = (3 if shape == QUAD else 2), u / -du
    if shape == QUAD:
        if du > 0 and u + du > 1 and (1 - u) / du < t:
            side, t = 1, (1 - u) / du
        if dv > 0 and v + dv > 1 and (1 - v) / dv < t:
            side, t = 2, (1 - v) / dv
    elif du + dv > 0 and u + v + du + dv > 1 and (1 - u - v) / (du + dv) < t:
        side, t = 1, (1 - u - v) / (du + dv)
    return side, min(max(t, 0.0), 1.0)


@inlined_kernel
def on_side(shape, side, u, v):  # type: ignore[no-untyped-def]
    """Put parameters that lie on a side but for rounding exactly there."""
    u, v = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
    if side == 0:
        v = 0.0
    elif side == 1:
        if shape == QUAD:
            u = 1.0
        else:
            v = 1 - u
    elif side == 2 and shape == QUAD:
        v = 1.0
    elif side >= 2:
        u = 0.0
    return u, v


@inlined_kernel
def walk(cells, cell, u, v, du, dv):  # type: ignore[no-untyped-def]
    """Go from (u, v) of a cell along (du, dv), across smooth sides, up to a sharp one.

    Returns
    -------
    cell, u, v : where it ends.
    """
    for _ in range(MAX_CROSSINGS):
        shape = cells.shape[cell]
        side, t = first_side_hit(shape, u, v, du, dv)
        u, v = on_side(shape, side, u + t * du, v + t * dv)
        if side < 0 or cells.sharp[cell, side]:
            break
        cell, u, v, du, dv = cross(cells, cell, side, u, v, (1 - t) * du, (1 - t) * dv)
    # Crossing leaves rounding errors of either sign.
    u, v = max(u, 0.0), max(v, 0.0)
    if cells.shape[cell] == QUAD:
        u, v = min(u, 1.0), min(v, 1.0)
    elif u + v > 1:
        u, v = u / (u + v), v / (u + v)
    return cell, u, v


@inlined_kernel
def newton_step(e, x, y, z, second):  # type: ignore[no-untyped-def]
    """Newton's step for the squared distance, from the expansion `e`.

    With `second` false, or where the Hessian is not positive, it is the Gauss-Newton step: the point projected to the
    tangent plane, a 2 x 2 system (Nishiyama et al. 2008, section 4).

    Returns
    -------
    du, dv : the step.
    h0, h1, h2 : the matrix used, by uu, uv, vv.
    gu, gv : the gradient.
    """
    rx, ry, rz = e[0] - x, e[1] - y, e[2] - z
    gu = e[3] * rx + e[4] * ry + e[5] * rz
    gv = e[6] * rx + e[7] * ry + e[8] * rz
    m0 = e[3] * e[3] + e[4] * e[4] + e[5] * e[5]
    m1 = e[3] * e[6] + e[4] * e[7] + e[5] * e[8]
    m2 = e[6] * e[6] + e[7] * e[7] + e[8] * e[8]
    h0, h1, h2 = m0, m1, m2
    if second:
        f0 = m0 + e[9] * rx + e[10] * ry + e[11] * rz
        f1 = m1 + e[12] * rx + e[13] * ry + e[14] * rz
        f2 = m2 + e[15] * rx + e[16] * ry + e[17] * rz
        if f0 > 0 and f2 > 0 and f0 * f2 - f1 * f1 > POSITIVE * (m0 * m2 - m1 * m1):
            h0, h1, h2 = f0, f1, f2
    determinant = h0 * h2 - h1 * h1
    if determinant <= 1e-14 * h0 * h2:
        # Parameters collapse here: descend along each by itself.
        du = -gu / h0 if h0 > 0 else 0.0
        dv = -gv / h2 if h2 > 0 else 0.0
        return 0.5 * du, 0.5 * dv, h0, h1, h2, gu, gv
    return (h1 * gv - h2 * gu) / determinant, (h1 * gu - h0 * gv) / determinant, h0, h1, h2, gu, gv


@inlined_kernel
def lies_on(shape, side, u, v):  # type: ignore[no-untyped-def]
    """Whether (u, v) lies on a side of its cell."""
    if side == 0:
        return v <= ON_SIDE
    if side == 1:
        return (u if shape == QUAD else u + v) >= 1 - ON_SIDE
    if side == 2 and shape == QUAD:
        return v >= 1 - ON_SIDE
    return u <= ON_SIDE


@inlined_kernel
def leads_out(shape, side, du, dv):  # type: ignore[no-untyped-def]
    """Whether (du, dv) leads through a side from inside."""
    if side == 0:
        return dv < 0
    if side == 1:
        return (du if shape == QUAD else du + dv) > 0
    if side == 2 and shape == QUAD:
        return dv > 0
    return du < 0


@inlined_kernel
def leaving_side(shape, u, v, du, dv):  # type: ignore[no-untyped-def]
    """Side on which (u, v) lies and through which (du, dv) leaves at once; -1 if none."""
    for side in range(shape):
        if lies_on(shape, side, u, v) and leads_out(shape, side, du, dv):
            return side
    return -1


@inlined_kernel
def other_side_at(shape, u, v, side):  # type: ignore[no-untyped-def]
    """The second side on which (u, v) lies when it is a corner; -1 if it is none."""
    for other in range(shape):
        if other != side and lies_on(shape, other, u, v):
            return other
    return -1


@inlined_kernel
def slide(shape, side, h0, h1, h2, gu, gv):  # type: ignore[no-untyped-def]
    """Newton's step along a side."""
    au, av = from_side(shape, side, 0.0, 0.0)
    bu, bv = from_side(shape, side, 1.0, 0.0)
    tu, tv = bu - au, bv - av
    h = tu * tu * h0 + 2 * tu * tv * h1 + tv * tv * h2
    s = -(gu * tu + gv * tv) / h if h > 0 else 0.0
    return s * tu, s * tv


@inlined_kernel
def squared_distance(e, x, y, z):  # type: ignore[no-untyped-def]
    """Squared distance from the expansion's point."""
    return (e[0] - x) ** 2 + (e[1] - y) ** 2 + (e[2] - z) ** 2


@inlined_kernel
def direction(patches, cells, cell, u, v, x, y, z, e, spare, cache, tags, second):  # type: ignore[no-untyped-def]
    """Step to try from (u, v), whose expansion is `e`: Newton's, or along a sharp side it would leave through.

    At a crease the face beyond is asked first: if its own step leads into it, the step is taken there.

    Returns
    -------
    cell, u, v, du, dv : where the step starts, and the step.
    """
    shape = cells.shape[cell]
    du, dv, h0, h1, h2, gu, gv = newton_step(e, x, y, z, second)
    side = leaving_side(shape, u, v, du, dv)
    if side < 0:
        return cell, u, v, du, dv
    if not cells.sharp[cell, side]:
        # At a corner with a sharp side, descend along that before going round the corner.
        beside = other_side_at(shape, u, v, side)
        if beside >= 0 and cells.sharp[cell, beside]:
            su, sv = slide(shape, beside, h0, h1, h2, gu, gv)
            if leaving_side(shape, u, v, su, sv) < 0 and su * su + sv * sv > 1e-20:
                return cell, u, v, su, sv
        return cell, u, v, du, dv
    if cells.neighbour[cell, side] >= 0:
        other, nu, nv, _, _ = cross(cells, cell, side, u, v, 0.0, 0.0)
        nu, nv = min(max(nu, 0.0), 1.0), min(max(nv, 0.0), 1.0)
        expand(patches, other, nu, nv, spare, cache, tags)
        eu, ev, _, _, _, _, _ = newton_step(spare, x, y, z, second)
        if leaving_side(cells.shape[other], nu, nv, eu, ev) < 0:
            for i in range(18):
                e[i] = spare[i]
            return other, nu, nv, eu, ev
    du, dv = slide(shape, side, h0, h1, h2, gu, gv)
    other_side = leaving_side(shape, u, v, du, dv)
    if other_side >= 0 and cells.sharp[cell, other_side]:
        # In a corner between two sharp sides: along the other one, or nowhere.
        du, dv = slide(shape, other_side, h0, h1, h2, gu, gv)
        if leaving_side(shape, u, v, du, dv) >= 0:
            return cell, u, v, 0.0, 0.0
    return cell, u, v, du, dv


@kernel
def project(  # type: ignore[no-untyped-def]
    patches, cells, points, order, start, stop, tolerance, iterations, second, cell, uv, squared, converged
):
    """Move footpoints to the nearest point, each from where it stands; none ends farther away than it began.

    Parameters
    ----------
    points : (k, 3).
    order : the rows to treat are ``order[start:stop]``.
    tolerance : a footpoint is settled when its next step on the surface is shorter than this.
    second : use second derivatives where the Hessian is positive.
    cell, uv, squared, converged : (k,), (k, 2), (k,), (k,) updated; `squared` is the squared distance.
    """
    cache = np.empty(48 * SLOTS)
    tags = np.full(SLOTS, -1, np.int64)
    e, trial = np.empty(18), np.empty(18)
    for n in range(start, stop):
        k = order[n]
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        c, u, v, f = cell[k], uv[k, 0], uv[k, 1], np.inf
        c1, u1, v1, du, dv = c, u, v, 0.0, 0.0
        steps = shortened = idle = 0
        settled = False
        while True:
            expand(patches, c1, u1, v1, trial, cache, tags)
            f1 = squared_distance(trial, x, y, z)
            if f1 < f or (f1 == f and c1 != c):
                idle = idle + 1 if f1 == f else 0
                c, u, v, f = c1, u1, v1, f1
                e, trial = trial, e
                settled = idle > 6
                if settled or steps == iterations:
                    break
                steps, shortened = steps + 1, 0
                c, u, v, du, dv = direction(patches, cells, c, u, v, x, y, z, e, trial, cache, tags, second)
                length = 0.0
                for d in range(3):
                    length += (du * e[3 + d] + dv * e[6 + d]) ** 2
                settled = length <= tolerance * tolerance
                if settled:
                    break
            else:
                shortened += 1
                # Stuck at a corner or a kink, or at the limit of rounding.
                settled = shortened == BACKTRACKS
                if settled:
                    break
                du, dv = 0.25 * du, 0.25 * dv
            c1, u1, v1 = walk(cells, c, u, v, du, dv)
        cell[k], uv[k, 0], uv[k, 1] = c, u, v
        squared[k] = f
        converged[k] = settled

"""How a fit converges, for every scheme: its error as the control mesh is refined, and to a surface of its own."""

import numpy as np
import pytest

from shapes.mixed import cut_some
from shapes.polygons import polygons, prism_data
from shapes.zoo import icosahedron_data
from subdfit.fit.data import FitData
from subdfit.fit.settings import FitSettings
from subdfit.fit.state import FOOTPOINT_TOLERANCE, FitState
from subdfit.fit.tangent import TangentSettings
from subdfit.fit.tangential import Tangential
from subdfit.limit import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure import Tolerance
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.schemes import SCHEMES
from subdfit.target.frame import Frame
from subdfit.target.target import Target, mesh_target

EVERY = pytest.mark.parametrize("scheme", SCHEMES)

CUBE, FACES = prism_data(4)
CUBES = {"loop": icosahedron_data(), "quad-triangle": (CUBE, cut_some(FACES, 1))}
"""What control meshes are refined from, where it is no cube: triangles, and a cube with triangles among its quads."""


def sphere_of(scheme: str, halvings: int) -> ControlMesh:
    """Control points on the unit sphere, joined in triangles, in quads, or in both."""
    refining = SCHEMES[scheme if scheme in CUBES else "catmull-clark"]
    base = CUBES.get(scheme, (CUBE, FACES))
    topology, points = polygons(base, scheme).topology, np.asarray(base[0], float)
    for _ in range(halvings):
        step = refining.refine(topology)
        topology, points = step.child, step.refined(points)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    return ControlMesh(topology, points)


def fitted(mesh: ControlMesh, scheme: str, target: Target, rounds: int, **weights: float) -> FitState:
    """The state after some rounds in which control points move freely and none is added."""
    frame = Frame.of(target.points)
    data = FitData.of(target.normalised(frame), 0.1)
    state = FitState.start(data, LimitSurface(mesh.with_points(frame.inside(mesh.points)), scheme))
    full = FitSettings(tolerance=Tolerance(max=1e-12), max_control_vertices=len(mesh.points))
    method = Tangential(full, TangentSettings(relaxation=0.0, reverse_weight=0.0, **weights))
    for _ in range(rounds):
        state = method.advance(state)
    assert state.surface.topology is mesh.topology
    return state


ORDERS = {
    "loop": (3.0, 4.0),
    "catmull-clark": (3.0, 4.0),
    "doo-sabin": (3.0, 3.0),
    "doo-sabin-averaging": (3.0, 3.0),
    "quad-triangle": (2.5, 4.0),
}
"""Powers of the spacing h that the root mean square falls with, in the limit: at least and at most.

Regular patches reproduce cubics, Doo-Sabin's quadratics: at most it is h^4, and h^3. Round irregular vertices not all
quadratics are reproduced and the error is of second order: over an area of h^2 that makes h^3 at least. Nor are they
along seams of triangles and quads: over a strip as wide as h that makes h^2.5.
"""


@EVERY
def test_error_on_a_sphere_falls_with_a_power_of_the_spacing(scheme: str, ball: Target) -> None:
    first = 0 if scheme == "loop" else 1
    coarse, fine = (fitted(sphere_of(scheme, first + k), scheme, ball, rounds=4).errors.rms for k in (0, 3))
    slowest, fastest = ORDERS[scheme]
    assert slowest - 0.25 < np.log2(coarse / fine) / 3 < fastest + 0.25


@EVERY
def test_a_control_mesh_is_recovered_from_its_own_surface(scheme: str) -> None:
    """Points that pull along normals alone determine it: on a bumpy surface none can slide for free.

    The error ends where footpoints do; control points err by as much times the condition of the least-squares problem.
    """
    mesh, random = sphere_of(scheme, 1 if scheme == "loop" else 2), np.random.default_rng(0)
    known = mesh.with_points(mesh.points * [1.0, 0.8, 1.3] + 0.08 * random.normal(size=mesh.points.shape))
    surface = LimitSurface(known, scheme)
    grid = lattice(surface.domain, 6)
    target = mesh_target(surface.evaluate(grid.face, grid.uv).position, grid.triangles, creases="none")
    start = known.with_points(known.points + 0.03 * random.normal(size=mesh.points.shape))
    found = fitted(start, scheme, target, rounds=10, tangential=0.0, fairness=0.0)
    gap = found.surface.control_mesh.points - Frame.of(target.points).inside(known.points)
    assert found.errors.max < 3 * FOOTPOINT_TOLERANCE
    assert np.abs(gap).max() < 1e-3

"""The reverse side: where the surface bulges between few data."""

import pytest
from tests.shapes.drilled import drilled_block
from tests.shapes.parts import can, shaft

from subdfit.fit.driver import fit_target
from subdfit.fit.settings import FitSettings
from subdfit.initial.start import start_mesh
from subdfit.limit import LimitSurface
from subdfit.limit.tessellate import lattice
from subdfit.measure import Tolerance, measure, reverse_segments, surface_samples
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.target.frame import Frame
from subdfit.target.target import mesh_target


@pytest.mark.parametrize(("shape", "vertices", "scheme"), [(can, 90, "loop"), (drilled_block, 60, "catmull-clark")])
def test_no_tessellation_finds_a_point_farther_off(shape, vertices: int, scheme: str) -> None:
    """At creases and extraordinary vertices the surface bulges in a hundredth of a cell."""
    target = mesh_target(*shape(), creases=30.0)
    target = target.normalised(Frame.of(target.points))
    surface = LimitSurface(start_mesh(target, vertices, 1e-3), scheme)
    found = measure(surface, target, spacing=0.02)
    grid = lattice(surface.domain, 64)
    places = surface.evaluate(grid.face, grid.uv).position
    assert found.reverse_max >= 0.99 * target.tree.closest(places).distance.max()
    assert found.reverse_excess >= 0.99 * target.gaps(places).max()


@pytest.mark.parametrize("scheme", ["loop", "catmull-clark", "doo-sabin", "quad-triangle"])
@pytest.mark.parametrize("shape", [can, shaft, drilled_block])
def test_samples_eight_times_finer_find_nothing_farther_off_a_fit(shape, scheme: str) -> None:
    """Where a few rounds leave it, ridges of the distance run across cells in all directions."""
    target = mesh_target(*shape(), creases=30.0)
    target = target.normalised(Frame.of(target.points))
    mesh = fit_target(target, FitSettings(tolerance=Tolerance(max=1e-3), scheme=scheme, max_iterations=3)).control_mesh
    surface = LimitSurface(mesh, scheme)
    found = measure(surface, target, spacing=0.02)
    grid = lattice(surface.domain, 8 * reverse_segments(surface.domain))
    nearest = target.tree.closest(places := surface.evaluate(grid.face, grid.uv).position)
    assert found.reverse_max >= 0.99 * nearest.distance.max()
    assert found.reverse_excess >= 0.99 * (nearest.distance - target.allowance(places, nearest)).max()
    assert found.reverse_max >= found.reverse_excess


def test_a_surface_far_larger_than_its_target_is_sampled_no_more_finely_than_any() -> None:
    target = mesh_target(*can())
    mesh = start_mesh(target.normalised(Frame.of(target.points)), 200, 1e-3)
    huge = LimitSurface(ControlMesh(mesh.topology, 1e3 * mesh.points), "loop")
    assert len(surface_samples(huge).face) < 1.5e6

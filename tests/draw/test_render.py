"""The renderer: coverage, occlusion and colours, told from the pixels."""

import numpy as np
import pytest
from pixels import covered, painted, reddish, sphere

from shapes import grids
from shapes.parts import can
from subdfit.draw.camera import camera_for
from subdfit.draw.depth import DepthPicture, Grid
from subdfit.draw.shading import is_closed, openness, signed_volume, smooth_normals
from subdfit.errors import InputError

RED = (0.9, 0.05, 0.05)
BALL = sphere()
FRONT = camera_for(*BALL, azimuth=0.0, elevation=0.0)


def both(one, other):
    return np.vstack([one[0], other[0]]), np.vstack([one[1], other[1] + len(one[0])])


@pytest.mark.parametrize("rows", [40, 420])
def test_a_sphere_covers_its_disc_without_gaps(rows):
    points, triangles = sphere(rows)
    camera = camera_for(points, triangles, azimuth=20.0, elevation=30.0)
    shown = covered(painted(points, triangles, camera=camera, inches=3.0))
    left, right, bottom, top = camera.window
    half_angle = np.arcsin(1.0 / camera.distance)
    disc = np.pi * (np.tan(half_angle) * camera.distance) ** 2 / ((right - left) * (top - bottom))
    assert shown.mean() == pytest.approx(disc, rel=0.02)
    for row in shown:
        across = np.flatnonzero(row)
        assert len(across) == 0 or len(across) == across[-1] - across[0] + 1


def test_light_comes_from_above_and_from_the_left():
    grey = painted(*BALL, camera=FRONT).mean(axis=2)
    size = len(grey)
    assert grey[size // 4, size // 3] > grey[3 * size // 4, 2 * size // 3] + 0.1


def test_a_closed_mesh_may_be_inside_out():
    points, triangles = BALL
    np.testing.assert_allclose(
        painted(points, triangles, camera=FRONT), painted(points, triangles[:, ::-1], camera=FRONT), atol=0.02
    )


@pytest.mark.parametrize(("z", "visible"), [(-3.0, False), (1.5, True)])
def test_the_nearer_surface_hides_the_farther(z, visible):
    points, triangles = both(BALL, sphere(16, 0.3, (0.0, 0.0, z)))
    colors = np.where((np.arange(len(triangles)) < len(BALL[1]))[:, None], 0.7, RED)
    assert reddish(painted(points, triangles, camera=FRONT, colors=colors)).any() == visible


@pytest.mark.parametrize(("z", "visible"), [(-1.0, False), (1.001, True)])
def test_the_surface_hides_lines_behind_it(z, visible):
    at = np.linspace(-0.04, 0.04, 9)
    lines = np.stack(
        [np.stack([at[:-1], 0 * at[1:], z + 0 * at[1:]], 1), np.stack([at[1:], 0 * at[1:], z + 0 * at[1:]], 1)], 1
    )
    shown = reddish(painted(*BALL, camera=FRONT, lines=lines, line_colors=RED, line_width=2.0))
    assert shown.any() == visible


def test_the_edges_of_the_back_stay_hidden():
    points, triangles = BALL
    middle = points[triangles].mean(axis=1)
    lines = points[np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)]
    colors = np.repeat(np.where(middle[:, 2:] < -0.2, RED, (0.1, 0.1, 0.1)), 3, axis=0)
    shown = reddish(painted(points, triangles, camera=FRONT, lines=lines.reshape(-1, 2, 3), line_colors=colors))
    assert not shown.any()


def test_an_open_surface_shows_its_inner_side_bluer():
    points, triangles = BALL
    bowl = triangles[np.all(points[triangles][:, :, 2] <= 0.01, axis=1)]
    inner = painted(points, bowl, camera=FRONT)
    outer = painted(points * [1, 1, -1], bowl[:, ::-1], camera=FRONT)
    size = len(inner) // 2
    assert inner[size, size, 2] / inner[size, size, 0] > outer[size, size, 2] / outer[size, size, 0] + 0.1


def test_numbers_at_the_vertices_become_colours():
    points, triangles = BALL
    picture = painted(points, triangles, camera=FRONT, colors=points[:, 1], cmap="bwr")
    size = len(picture)
    top, foot = picture[size // 5, size // 2], picture[4 * size // 5, size // 2]
    assert top[0] > top[2] + 0.2
    assert foot[2] > foot[0] + 0.2


def test_colours_that_fit_nothing_are_refused():
    with pytest.raises(InputError, match=r"colors of shape \(7,\)"):
        painted(*BALL, camera=FRONT, colors=np.zeros(7))


def test_closed_means_every_directed_edge_has_its_opposite():
    _, triangles = BALL
    assert is_closed(triangles)
    assert not is_closed(triangles[1:])
    assert not is_closed(np.vstack([triangles[:1, ::-1], triangles[1:]]))
    assert not is_closed(np.vstack([triangles, triangles]))


def test_the_volume_of_a_sphere():
    points, triangles = sphere(160)
    assert signed_volume(points, triangles) == pytest.approx(4.0 / 3.0 * np.pi, rel=1e-3)
    assert signed_volume(points, triangles[:, ::-1]) == pytest.approx(-4.0 / 3.0 * np.pi, rel=1e-3)


def test_normals_are_smooth_on_a_sphere_and_sharp_on_a_cube():
    points, triangles = BALL
    middles = points[triangles].mean(axis=1)
    middles /= np.linalg.norm(middles, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", smooth_normals(points, triangles), middles).min() > np.cos(np.radians(2.0))
    corners = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    sides = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6]])
    sides = np.vstack([sides, [[0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]])
    own = np.cross(corners[sides[:, 1]] - corners[sides[:, 0]], corners[sides[:, 2]] - corners[sides[:, 0]])
    np.testing.assert_allclose(smooth_normals(corners, sides), own, atol=1e-6)


def test_rims_have_the_normals_of_both_sides():
    """A can, whose lids and wall meet in the same vertices; its wall is a polygon of 7.5 degrees a side."""
    points, triangles = can()
    found = smooth_normals(points, triangles)
    middle = points[triangles].mean(axis=1)
    lid = np.ptp(points[triangles][:, :, 2], axis=1) == 0
    wall = np.where(lid[:, None], [0.0, 0.0, 1.0] * np.sign(middle), middle * [1.0, 1.0, 0.0])
    wall /= np.linalg.norm(wall, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", found, wall).min() > np.cos(np.radians(4.0))


def test_hollows_are_dark():
    x, y = np.meshgrid(np.linspace(0, 1, 300), np.linspace(0, 1, 300))
    pit = -0.03 * np.exp(-((x - 0.5) ** 2 + (y - 0.5) ** 2) / 0.001)
    sheet = np.stack([x, y, pit], axis=2).reshape(-1, 3).astype(np.float32)
    free = openness(sheet, (0.0, 1.0, 0.0, 1.0), 100).reshape(300, 300)
    assert free[60, 60] == pytest.approx(1.0, abs=0.01)
    assert free[150, 150] < 0.8


def test_each_sample_sees_the_nearest_of_crossing_triangles():
    rng = np.random.default_rng(0)
    points, faces = rng.uniform(-1.0, 1.0, (60, 3)), np.arange(60).reshape(20, 3)
    camera = camera_for(points, faces, azimuth=10.0, elevation=20.0)
    left, right, bottom, top = camera.window
    grid = Grid(left, bottom, (right - left) / 60, 4 * int(15 * (top - bottom) / (right - left)), 60)
    depth = DepthPicture(camera.project(points), faces, camera, grid)
    shown = depth.colored(np.eye(20, 3, dtype=np.float32))[:, :, 3]
    column, row = np.meshgrid(np.arange(grid.columns), np.arange(grid.rows))
    rays = np.stack([left + (column + 0.5) * grid.cell, bottom + (row + 0.5) * grid.cell], axis=2).reshape(-1, 2)
    eye = camera.centre + camera.distance * camera.rotation[2]
    through = camera.centre + rays @ camera.rotation[:2]
    first = np.full(len(rays), np.inf)
    for a, b, c in points[faces]:
        # Where the ray from the eye meets the plane, as shares of the way and of the sides.
        ways = np.stack(
            [through - eye, np.broadcast_to(a - b, through.shape), np.broadcast_to(a - c, through.shape)], 2
        )
        t, u, v = np.linalg.solve(ways, (a - eye)[None, :, None])[:, :, 0].T
        met = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
        first[met] = np.minimum(first[met], t[met])
    met = np.isfinite(first)
    assert shown.mean() == pytest.approx(met.mean(), abs=2e-3)
    at = eye + first[met, None] * (through - eye)[met]
    step = 6.0 * grid.cell * camera.rotation[2]
    assert not depth.hides(camera.project(at)).any()
    assert not depth.hides(camera.project(at + step)).any()
    inside = np.abs(rays[met]).max(axis=1) < 0.3
    assert depth.hides(camera.project(at[inside] - step)).mean() > 0.5


def plate(cells, thickness):
    """A closed box of width and height 1 on a grid of cells, z from -thickness to 0, its front faces first."""
    x, y = np.meshgrid(np.linspace(0, 1, cells + 1), np.linspace(0, 1, cells + 1))
    front = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)
    i = grids.vertices(cells + 1, cells + 1)
    face = grids.triangles_of(i.T)
    rim = np.concatenate([i[0, :-1], i[:-1, -1], i[-1, :0:-1], i[:0:-1, 0]])
    after, back = np.roll(rim, -1), len(front)
    wall = np.concatenate([np.stack([rim, rim + back, after], 1), np.stack([after, rim + back, after + back], 1)])
    return np.vstack([front, front - [0, 0, thickness]]), np.vstack([face, face[:, ::-1] + back, wall])


@pytest.mark.parametrize("cells", [1, 8, 60])
@pytest.mark.parametrize("closed", [True, False])
def test_lines_on_the_far_side_of_a_thin_plate_leave_no_pixel(cells, closed):
    points, triangles = plate(cells, 0.01)
    assert is_closed(triangles)
    triangles = triangles if closed else triangles[: -4 * cells]
    across = np.linspace(0.05, 0.95, 7)
    ends = np.array([[[0.1, t], [0.9, t]] for t in across] + [[[t, 0.1], [t, 0.9]] for t in across])
    camera = camera_for(points, triangles, azimuth=30.0, elevation=20.0)
    for z, visible in ((-0.01, False), (0.0, True)):
        lines = np.concatenate([ends, np.full((len(ends), 2, 1), z)], axis=2)
        shown = reddish(painted(points, triangles, camera=camera, lines=lines, line_colors=RED, line_width=1.5))
        assert shown.any() == visible


def test_edges_are_seen_whole_however_steep_the_mesh():
    points, triangles = plate(8, 0.3)
    front = points[:, 2] == 0.0
    lines = np.array([[[0.0, k / 8, 0.0], [1.0, k / 8, 0.0]] for k in range(1, 8)])
    camera = camera_for(points, triangles, azimuth=80.0, elevation=0.0)
    picture = painted(points, triangles, camera=camera, lines=lines, line_colors=RED, line_width=1.0, inches=2.0)
    seen = camera.project(points[front])
    left, right, _, _ = camera.window
    share = np.ptp(seen[:, 0]) / (right - left)
    columns = reddish(picture).sum(axis=0)
    assert (columns >= 7).sum() >= 0.95 * share * picture.shape[1] - 2


@pytest.mark.parametrize(("anchor", "visible"), [(None, False), (1.0, True), (-1.0, False)])
def test_lines_off_the_surface_are_seen_where_their_anchors_are(anchor, visible):
    lines = np.array([[[-0.1, 0.0, 0.7], [0.1, 0.0, 0.7]]])
    anchors = None if anchor is None else np.where([False, False, True], anchor, lines)
    shown = reddish(painted(*BALL, camera=FRONT, lines=lines, line_colors=RED, line_width=2.0, line_anchors=anchors))
    assert shown.any() == visible


@pytest.mark.parametrize("sections", [16, 90])
def test_the_near_wall_of_an_open_thin_tube_hides_the_far_wall(sections):
    angle = 2 * np.pi * np.arange(sections) / sections
    ring = np.stack([0.03 * np.sin(angle), 0 * angle, 0.01 * np.cos(angle)], axis=1)
    height = np.linspace(0.0, 1.0, 4)
    points = np.concatenate([ring + np.array([0.0, y, 0.0]) for y in height])
    triangles = grids.triangles_of(grids.wrapped(grids.vertices(len(height), sections)).T)
    far = points[triangles][:, :, 2].mean(axis=1) < 0.0
    camera = camera_for(points, triangles, azimuth=0.0, elevation=40.0)
    colors = np.where(far[:, None], RED, 0.7)
    shown = painted(points, triangles, camera=camera, colors=colors, inches=0.5)
    assert not reddish(shown)[len(shown) // 10 :].any()

"""A bent plate with round holes, evenly meshed."""

import numpy as np
from scipy.spatial import Delaunay

WIDTH, HEIGHT, RADIUS, STEP, SECTIONS = 60.0, 40.0, 4.0, 1.5, 24
HOLES = ((12.0, 10.0), (48.0, 10.0), (12.0, 30.0), (48.0, 30.0))


def bent_plate(holes=HOLES, rise=20.0):
    """Points and triangles of a rectangle with holes at some middles, bent along a parabola that rises so far."""
    across, up = (np.linspace(0.0, size, round(size / STEP) + 1) for size in (WIDTH, HEIGHT))
    grid = np.stack(np.meshgrid(across, up), axis=-1).reshape(-1, 2)
    angle = 2 * np.pi * np.arange(SECTIONS) / SECTIONS
    circle = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    away = np.min([np.linalg.norm(grid - hole, axis=1) for hole in holes], axis=0) > RADIUS + 0.5 * STEP
    flat = np.concatenate([grid[away], *(circle + hole for hole in holes)])
    triangles = Delaunay(flat).simplices
    middle = flat[triangles].mean(axis=1)
    outside = np.min([np.linalg.norm(middle - hole, axis=1) for hole in holes], axis=0) > 0.99 * RADIUS
    corners = flat[triangles]
    double = np.linalg.det(np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=1))
    triangles[double < 0] = triangles[double < 0][:, ::-1]
    points = np.column_stack([flat, rise * (flat[:, 0] / WIDTH) ** 2])
    return points, triangles[outside & (np.abs(double) > 1e-9)].astype(np.int64)

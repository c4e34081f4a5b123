"""Shapes to paint, and what the painted pixels show."""

import io

import numpy as np
from matplotlib.image import imread

from subdfit.draw.page import axes_at, new_figure, png
from subdfit.draw.render import render


def sphere(rows=40, radius=1.0, centre=(0.0, 0.0, 0.0)):
    """A closed sphere of latitude rings, oriented outwards."""
    around = 2 * rows
    latitude = np.linspace(0.0, np.pi, rows + 1)[1:-1]
    longitude = np.arange(around) * 2 * np.pi / around
    t, p = np.meshgrid(latitude, longitude, indexing="ij")
    ring = np.stack([np.sin(t) * np.sin(p), np.cos(t), np.sin(t) * np.cos(p)], axis=2).reshape(-1, 3)
    points = np.vstack([ring, [[0, 1, 0], [0, -1, 0]]]) * radius + centre
    k, j = np.meshgrid(np.arange(rows - 2), np.arange(around), indexing="ij")
    a, b = k * around + j, k * around + (j + 1) % around
    sides = np.concatenate([np.stack([a, a + around, b], 2), np.stack([b, a + around, b + around], 2)]).reshape(-1, 3)
    j, after = np.arange(around), (np.arange(around) + 1) % around
    north, south = (rows - 1) * around, (rows - 1) * around + 1
    last = (rows - 2) * around
    caps = [
        np.stack([j, after, np.full(around, north)], 1),
        np.stack([last + after, last + j, np.full(around, south)], 1),
    ]
    return points, np.vstack([sides, *caps])


def painted(vertices, triangles, *, camera, inches=2.0, **options):
    """The picture as (rows, columns, 3) colours from 0 to 1."""
    figure = new_figure(inches, inches / camera.aspect)
    render(axes_at(figure, 0, 0, inches, inches / camera.aspect), vertices, triangles, camera=camera, **options)
    return imread(io.BytesIO(png(figure)))[:, :, :3]


def covered(picture):
    """Which pixels are not the white background."""
    return picture.min(axis=2) < 0.999


def reddish(picture):
    """Which pixels are more red than anything else."""
    return picture[:, :, 0] > 1.6 * picture[:, :, 1:].max(axis=2) + 0.05

"""Chains of points on known curves."""

import numpy as np

from subdfit.curves.polyline import Polyline


def circle(count, radius=1.0):
    angle = 2 * np.pi * np.arange(count) / count
    return Polyline(radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1), closed=True)


def ellipse(count=100):
    angle = 2 * np.pi * np.arange(count) / count
    return Polyline(np.stack([3 * np.cos(angle), np.sin(angle), 0.3 * np.sin(2 * angle)], 1), closed=True)


def damped_wave(count=100):
    s = np.linspace(0, 6, count)
    return Polyline(np.stack([s, np.sin(s) * np.exp(-s / 3), 0 * s], 1))


def outline(step=0.05):
    """As in the paper's Figure 3: straight sides, a round end and a round notch, with six sharp points."""
    half = np.linspace(0, np.pi, int(np.pi / step) + 1)[:-1]
    sides = [[(0, 0), (2, 0)], [(3, 0), (5, 0)], [(5, 2), (2, 2)], [(2, 2), (2, 3)], [(2, 3), (0, 3)], [(0, 3), (0, 0)]]
    lines = [
        a + (b - a) * np.linspace(0, 1, int(np.linalg.norm(b - a) / step) + 1)[:-1, None] for a, b in np.array(sides)
    ]
    notch = np.stack([2.5 - 0.5 * np.cos(half), 0.5 * np.sin(half)], 1)
    end = np.stack([5 + np.sin(half), 1 - np.cos(half)], 1)
    xy = np.concatenate([lines[0], notch, lines[1], end, *lines[2:]])
    return Polyline(np.column_stack([xy, np.zeros(len(xy))]), closed=True)


def clothoid(count=100):
    """Curvature grows with the arc length, from nothing to five."""
    angle = np.linspace(0, 5, count) ** 2 / 2
    return Polyline(np.cumsum(np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1), axis=0) * 5 / count)

"""Triangles on a grid of samples: at each sample the nearest one stays."""

import numpy as np

from subdfit.compiled import kernel

_SLACK = 1e-6
"""Share of a cell by which rows of a triangle are longer than they are: rounding opens no gap between neighbours."""


@kernel
def paint_nearest(corners, face, nearness):  # type: ignore[no-untyped-def]
    """Write into each sample the triangle that is nearest there.

    Parameters
    ----------
    corners : (m, 3, 3) float64, column and row of each corner, where samples have whole numbers, and its nearness.
    face : (rows, columns) int32, changed: the triangle's number.
    nearness : (rows, columns) float32, changed: the nearness of what lies at the sample; linear over a triangle.
    """
    rows, columns = face.shape
    for k in range(len(corners)):
        ax, ay, aw = corners[k, 0]
        bx, by, bw = corners[k, 1]
        cx, cy, cw = corners[k, 2]
        twice_area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if twice_area == 0.0:
            continue
        along = ((bw - aw) * (cy - ay) - (cw - aw) * (by - ay)) / twice_area
        up = ((cw - aw) * (bx - ax) - (bw - aw) * (cx - ax)) / twice_area
        # Of a triangle seen edge-on a sample beside it may be far off in its plane.
        least, most = min(aw, bw, cw), max(aw, bw, cw)
        low, high = max(np.ceil(min(ay, by, cy)), 0.0), min(np.floor(max(ay, by, cy)), rows - 1.0)
        for row in range(int(low), int(high) + 1):
            left, right = np.inf, -np.inf
            for side in range(3):
                px, py = corners[k, side, 0], corners[k, side, 1]
                qx, qy = corners[k, (side + 1) % 3, 0], corners[k, (side + 1) % 3, 1]
                if py != qy and min(py, qy) <= row <= max(py, qy):
                    x = px + (row - py) / (qy - py) * (qx - px)
                    left, right = min(left, x), max(right, x)
            first, last = max(np.ceil(left - _SLACK), 0.0), min(np.floor(right + _SLACK), columns - 1.0)
            if not first <= last:
                continue
            for column in range(int(first), int(last) + 1):
                near = min(max(aw + along * (column - ax) + up * (row - ay), least), most)
                if near > nearness[row, column]:
                    nearness[row, column] = near
                    face[row, column] = k


@kernel
def mean_colors(face, colors, pixels):  # type: ignore[no-untyped-def]
    """Write into each pixel the mean colour of the faces at its samples, and the share of samples that have one.

    Parameters
    ----------
    face : (rows, columns) int32, -1 where there is none.
    colors : (m, 3) float32.
    pixels : (rows of pixels, columns of pixels, 4) float32 zeros, changed.
    """
    samples = face.shape[0] // pixels.shape[0]
    share = 1.0 / samples**2
    for row in range(face.shape[0]):
        for column in range(face.shape[1]):
            k = face[row, column]
            if k >= 0:
                for channel in range(3):
                    pixels[row // samples, column // samples, channel] += share * colors[k, channel]
                pixels[row // samples, column // samples, 3] += share
    for row in range(pixels.shape[0]):
        for column in range(pixels.shape[1]):
            if pixels[row, column, 3] > 0.0:
                for channel in range(3):
                    pixels[row, column, channel] /= pixels[row, column, 3]

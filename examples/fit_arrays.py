"""Fit arrays: vertices and triangles in, a light control mesh within tolerance out."""

import numpy as np

import subdfit


def wavy_torus(around: int = 160, across: int = 80) -> tuple[np.ndarray, np.ndarray]:
    """Return a dense mesh of a torus whose tube swells and shrinks, in millimetres."""
    i, j = (index.ravel() for index in np.indices((around, across)))
    angle, turn = 2 * np.pi * i / around, 2 * np.pi * j / across
    tube = 12 + 1.5 * np.cos(5 * angle) * np.cos(3 * turn)
    out = 40 + tube * np.cos(turn)
    points = np.column_stack([out * np.cos(angle), out * np.sin(angle), tube * np.sin(turn)])
    right, up = (i + 1) % around, (j + 1) % across
    a, b, c, d = i * across + j, right * across + j, right * across + up, i * across + up
    return points, np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


points, triangles = wavy_torus()

# A number is a length in the data's unit; "0.05%" would be a share of the bounding box's diagonal.
result = subdfit.fit((points, triangles), max_error=0.1, unit="mm")
print(result)

cage = result.control_mesh
print(f"{len(points):,} points became {cage.topology.vertex_count:,} control vertices, {cage.points.dtype}")
print(f"farthest data point: row {result.distances.argmax()}, {result.distances.max():.4f} mm from the surface")

subdfit.write("torus_cage.obj", cage)

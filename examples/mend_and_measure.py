"""Bad input and other people's control meshes: what is mended, and how to measure any cage against any target."""

import logging

import numpy as np
import trimesh

import subdfit

logging.basicConfig(format="%(levelname)s %(message)s")

# A capsule as a sloppy exporter writes it: no shared vertices, a face twice, a stray vertex.
capsule = trimesh.creation.capsule(height=40, radius=15, count=[48, 48])
corners = capsule.vertices[capsule.faces].reshape(-1, 3)
faces = np.arange(len(corners)).reshape(-1, 3)
points = np.vstack([corners, [[0, 0, 500]]])
faces = np.vstack([faces, faces[:1]])

result = subdfit.fit((points, faces), max_error="0.1%")  # logs one warning for each kind of flaw
print(result)

# The target's own coarse version, taken as a Loop control mesh, lies far off: Loop surfaces shrink inwards.
coarse = trimesh.creation.capsule(height=40, radius=15, count=[12, 12])
for name, cage in (("coarse mesh", (coarse.vertices, coarse.faces)), ("fitted cage", result.control_mesh)):
    found = subdfit.measure(cage, capsule)
    print(
        f"{name}: data to surface {100 * found.max:.3f} % at most, {100 * found.rms:.3f} % rms; "
        f"surface to data {100 * found.reverse_max:.3f} % at most"
    )

# What cannot be used is refused in one line.
points[7] = np.nan
try:
    subdfit.fit((points, faces))
except subdfit.InputError as error:
    print("refused:", error)

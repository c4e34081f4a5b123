"""The limit surface: exact positions, derivatives, normals and curvature anywhere; closest points."""

import numpy as np
import trimesh

import subdfit

RADIUS = 5.0
sphere = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
surface = subdfit.fit(sphere, max_error="0.02%").surface

# A face of the control mesh and two parameters name a point: corners (0, 0), (1, 0), (0, 1).
random = np.random.default_rng(0)
face = random.integers(surface.domain.face_count, size=10_000)
uv = random.dirichlet([1, 1, 1], size=len(face))[:, 1:]

found = surface.evaluate(face, uv, derivatives=2)
radius = np.linalg.norm(found.position, axis=1)
print(f"distance from the centre: {radius.min():.4f} to {radius.max():.4f}, the sphere's is {RADIUS}")

normal = surface.normals(face, uv)
outward = np.sum(normal * found.position, axis=1) / radius
print(f"angle between normal and radius: at most {np.degrees(np.arccos(outward.min())):.2f} degrees")

# Gaussian curvature from the two fundamental forms. Towards vertices of valence 3, 7 and more it is unbounded: Loop's
# scheme is like that, and so the median is the honest number here.
tangent, bend = found.first, found.second
first_form = np.einsum("kid,kjd->kij", tangent, tangent)
second_form = np.einsum("kid,kd->ki", bend, normal)
curvature = (second_form[:, 0] * second_form[:, 2] - second_form[:, 1] ** 2) / np.linalg.det(first_form)
print(f"Gaussian curvature: median {np.median(curvature):.4f}, the sphere's is {1 / RADIUS**2:.4f}")

# Closest points are found globally; a projection names face, parameters and distance.
queries = random.normal(size=(1000, 3)) * 2 * RADIUS
nearest = surface.closest(queries)
truth = np.abs(np.linalg.norm(queries, axis=1) - RADIUS)
print(f"distances agree with the sphere's to {np.abs(nearest.distance - truth).max():.4f}")

# A point is a fixed combination of control points: S(face, uv) = W P.
weights = surface.weights(face, uv)
print(f"W is {weights.shape[0]} x {weights.shape[1]}; W P differs from the evaluation by", end=" ")
print(f"{np.abs(weights @ surface.control_mesh.points - found.position).max():.1e}")

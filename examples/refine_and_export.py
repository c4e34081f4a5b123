"""Refine a control mesh, put it on the limit surface, and write it for other programs."""

import numpy as np

import subdfit

tetrahedron = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], float)
faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
subdfit.write("cage.obj", subdfit.subdivide((tetrahedron, faces), levels=0))

# Two steps of subdivision give a finer control mesh of the same surface.
finer = subdfit.subdivide("cage.obj", levels=2)
subdfit.write("cage_finer.ply", finer)
on_surface = subdfit.subdivide("cage.obj", levels=2, limit=True)
step = np.linalg.norm(on_surface.points - finer.points, axis=1).max()
print(f"{finer.topology.vertex_count} vertices; the limit surface lies at most {step:.4f} away from them")

a, b = subdfit.LimitSurface("cage.obj"), subdfit.LimitSurface("cage_finer.ply")
print(f"the same surface: {a.closest(b.evaluate([0, 50], [[0.2, 0.3], [0.6, 0.1]]).position).distance.max():.1e}")

# Renderers and slicers want triangles: these lie on the surface, with its exact normals. Renderers want each side of a
# crease to have its own, slicers one closed mesh.
surface = subdfit.LimitSurface("cage.obj")
mesh = surface.tessellate(4)
subdfit.write("surface.glb", surface.tessellate(4, apart=True))
subdfit.write("surface.stl", mesh)
print(f"{len(mesh.triangles)} triangles written")

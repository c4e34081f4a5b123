"""Run by a Python that has Blender as a module (``bpy``): limit points of control meshes by its subdivision surface.

``python blender_limits.py CAGES.npz LIMITS.npz QUALITY``. QUALITY is the level to which Blender isolates irregular
vertices before it puts approximate patches there. For every case NAME the first file holds ``NAME/points`` (n, 3),
``NAME/offsets`` and ``NAME/corners`` (ragged faces), ``NAME/creases`` (e, 3: two vertices and a crease from 0 to 1),
``NAME/pinned`` (c, 2: a vertex and its crease) and ``NAME/keep_corners``. The second gets ``NAME/limits``: vertices,
middles of edges, centres of faces; and ``NAME/edges`` (e, 2), the ends of those edges.
"""

import sys
from itertools import pairwise

import bpy
import numpy as np


def limits(points, offsets, corners, creases, pinned, keep_corners, quality):
    """Return limit points of a cage and the ends of its edges."""
    faces = [corners[a:b].tolist() for a, b in pairwise(offsets)]
    mesh = bpy.data.meshes.new("cage")
    mesh.from_pydata(points.tolist(), [], faces)
    edges = read(mesh.edges, "vertices", 2, np.int32)
    number = {tuple(sorted(ends)): e for e, ends in enumerate(edges.tolist())}
    creased = [number[tuple(sorted(ends))] for ends in creases[:, :2].astype(int).tolist()]
    tag(mesh, "crease_edge", "EDGE", len(edges), creased, creases[:, 2])
    tag(mesh, "crease_vert", "POINT", len(points), pinned[:, 0].astype(int), pinned[:, 1])
    cage = bpy.data.objects.new("cage", mesh)
    bpy.context.scene.collection.objects.link(cage)
    surface = cage.modifiers.new("surface", "SUBSURF")
    surface.levels, surface.quality, surface.use_limit_surface, surface.use_creases = 1, quality, True, True
    surface.boundary_smooth = "PRESERVE_CORNERS" if keep_corners else "ALL"
    evaluated = cage.evaluated_get(bpy.context.evaluated_depsgraph_get())
    found = read(evaluated.to_mesh().vertices, "co", 3, np.float32)
    bpy.data.objects.remove(cage)
    return found, edges


def tag(mesh, name, domain, count, rows, values):
    """Set an attribute of Blender's, zero but in some rows."""
    if len(rows):
        whole = np.zeros(count, np.float32)
        whole[rows] = values
        mesh.attributes.new(name, "FLOAT", domain).data.foreach_set("value", whole)


def read(collection, name, columns, dtype):
    """Return a property of all elements, (k, columns)."""
    flat = np.empty(columns * len(collection), dtype)
    collection.foreach_get(name, flat)
    return flat.reshape(-1, columns)


def main(source, target, quality):
    """Work through all cases of a file."""
    given, out = np.load(source), {"version": np.array(bpy.app.version_string)}
    for name in sorted({key.rsplit("/", 1)[0] for key in given}):
        parts = ("points", "offsets", "corners", "creases", "pinned", "keep_corners")
        values = [given[f"{name}/{part}"] for part in parts]
        out[f"{name}/limits"], out[f"{name}/edges"] = limits(*values, int(quality))
    np.savez(target, **out)


main(*sys.argv[1:])

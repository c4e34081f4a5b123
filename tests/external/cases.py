"""Control meshes that Blender is asked about, and the same limit points by us."""

from dataclasses import dataclass

import numpy as np

from subdfit.api import control_mesh_of
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes.domain import CORNERS


@dataclass(frozen=True)
class Case:
    """A model with tags strewn over a share of its edges and vertices.

    Attributes
    ----------
    model : file in the folder of quad meshes.
    edges, vertices : shares of edges and of vertices that are tagged.
    creases : least and largest crease, in Blender's measure from 0 to 1.
    keep_corners : whether boundary vertices of a single face are corners.
    """

    model: str
    edges: float = 0.0
    vertices: float = 0.0
    creases: tuple[float, float] = (1.0, 1.0)
    keep_corners: bool = False


MODELS = ("suzanne", "quadknot", "greek_helmet", "fandisk_quads")
CASES = {f"{model} smooth": Case(model) for model in MODELS}
CASES |= {f"{model} sharp": Case(model, 0.1, 0.02, keep_corners=True) for model in MODELS}
CASES |= {f"{model} semi-sharp": Case(model, 0.1, 0.02, (0.1, 0.6)) for model in MODELS}


def sharpness(crease):
    """OpenSubdiv's sharpness for Blender's crease: 10 crease^2, as its manual and subdivision kernel have it."""
    return 10 * np.float32(crease).astype(float) ** 2


@dataclass(frozen=True)
class Tagged:
    """A cage, with its tags as Blender measures them: two vertices and a crease, (e, 3); vertex and crease, (c, 2)."""

    mesh: ControlMesh
    creases: np.ndarray
    pinned: np.ndarray
    keep_corners: bool


def tagged(case, folder):
    """Read a model and strew the case's tags over it."""
    mesh = control_mesh_of(folder / "quad" / f"{case.model}.ply", "catmull-clark")
    t, random = mesh.topology, np.random.default_rng(17)
    inner = t.edge_vertices[~t.boundary_edges]
    edges = inner[random.random(len(inner)) < case.edges]
    vertices = np.flatnonzero(random.random(t.vertex_count) < case.vertices)
    crease, pin = (random.uniform(*case.creases, len(rows)) for rows in (edges, vertices))
    corners, strength = vertices, sharpness(pin)
    if case.keep_corners:
        boundary = np.unique(t.edge_vertices[t.boundary_edges])
        single = np.setdiff1d(boundary[t.valence[boundary] == 1], vertices)
        corners, strength = np.r_[vertices, single], np.r_[strength, np.full(len(single), np.inf)]
    topology = Topology.from_faces(
        t.face_offsets, t.face_vertices, t.vertex_count, edges, sharpness(crease), corners, strength
    )
    # Blender computes with single precision: give both the same numbers.
    points = mesh.points.astype(np.float32).astype(float)
    tags = np.column_stack([edges, crease]), np.column_stack([vertices, pin])
    return Tagged(ControlMesh(topology, points), *tags, case.keep_corners)


def our_limits(mesh):
    """Limit points at vertices, middles of edges and centres of faces, by evaluation, in our order."""
    surface, t = LimitSurface(mesh, "catmull-clark"), mesh.topology
    h = np.arange(len(t.face_vertices))
    if surface.domain.face_count == t.face_count:
        corner = h - t.face_offsets[t.face]
        begin, end = CORNERS[4][corner], CORNERS[4][(corner + 1) % 4]
        at_vertex, at_edge, centre = (t.face, begin), (t.face, (begin + end) / 2), np.full((t.face_count, 2), 0.5)
        at_centre = (np.arange(t.face_count), centre)
    else:
        at_vertex, at_edge = (h, np.zeros((len(h), 2))), (h, np.tile([1.0, 0.0], (len(h), 1)))
        at_centre = (t.face_offsets[:-1], np.ones((t.face_count, 2)))
    out = np.empty((t.vertex_count + t.edge_count + t.face_count, 3))
    out[t.face_vertices] = surface.evaluate(*at_vertex).position
    out[t.vertex_count + t.edge] = surface.evaluate(*at_edge).position
    out[t.vertex_count + t.edge_count :] = surface.evaluate(*at_centre).position
    return out


def rows_of(t, edges):
    """Our rows of Blender's points, whose edges have the given ends."""
    keys = {tuple(sorted(ends)): e for e, ends in enumerate(t.edge_vertices.tolist())}
    middle = [t.vertex_count + keys[tuple(sorted(ends))] for ends in edges.tolist()]
    return np.r_[np.arange(t.vertex_count), middle, t.vertex_count + t.edge_count + np.arange(t.face_count)]

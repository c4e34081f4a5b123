"""Semi-sharp creases and corners against a second refiner: OpenSubdiv's uniform rule in loops over vertices."""

from math import cos, inf, pi

import numpy as np
import pytest

from shapes.parameters import surface_of
from shapes.polygons import CHAIN
from shapes.zoo import mesh_of
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.topology import Topology
from subdfit.schemes import SCHEMES

BOTH = ["loop", "catmull-clark"]
SEMI = [
    *(("loop", name) for name in ("semi 0", "semi 1", "semi across")),
    *(("catmull-clark", name) for name in ("semi across", "quad semi crease", "prism semi")),
    *(("catmull-clark", f"semi quads {seed}") for seed in range(2)),
]


class Reference:
    """A mesh in plain Python: faces as lists, sharpness of edges by their ends and of vertices.

    DeRose, Kass and Truong 1998; for fractions the rules that OpenSubdiv documents as its uniform creasing method.
    """

    def __init__(self, scheme, faces, points, sharp_edges, sharp_vertices):
        self.scheme, self.faces, self.points = scheme, faces, points
        self.edges, self.vertices = dict(sharp_edges), dict(sharp_vertices)
        self.beside, self.round = {}, {v: [] for v in range(len(points))}
        for f, face in enumerate(faces):
            for a, b in zip(face, face[1:] + face[:1], strict=True):
                self.beside.setdefault(frozenset((a, b)), []).append(f)
                self.round[a].append(f)
        self.edges |= {edge: inf for edge, sides in self.beside.items() if len(sides) == 1}

    @classmethod
    def of(cls, scheme, mesh):
        t = mesh.topology
        faces = [t.face_vertices[a:b].tolist() for a, b in zip(t.face_offsets[:-1], t.face_offsets[1:], strict=True)]
        edges = {frozenset(ends.tolist()): s for ends, s in zip(t.edge_vertices, t.sharpness, strict=True) if s > 0}
        vertices = {v: s for v, s in enumerate(t.corner_sharpness) if s > 0}
        return cls(scheme, faces, list(mesh.points), edges, vertices)

    def centroid(self, f):
        return sum(self.points[v] for v in self.faces[f]) / len(self.faces[f])

    def neighbours(self, v):
        return [next(iter(edge - {v})) for edge in self.beside if v in edge]

    def edge_point(self, edge):
        a, b = (self.points[v] for v in edge)
        crease = min(self.edges.get(edge, 0), 1)
        if crease == 1:
            return (a + b) / 2
        if self.scheme == "loop":
            beside = [next(v for v in self.faces[f] if v not in edge) for f in self.beside[edge]]
            smooth = 3 / 8 * (a + b) + sum(self.points[v] for v in beside) / 8
        else:
            smooth = (a + b + sum(self.centroid(f) for f in self.beside[edge])) / 4
        return crease * (a + b) / 2 + (1 - crease) * smooth

    def smooth_point(self, v):
        near, n = self.neighbours(v), len(self.round[v])
        if self.scheme == "loop":
            beta = (5 / 8 - (3 / 8 + cos(2 * pi / n) / 4) ** 2) / n
            return (1 - n * beta) * self.points[v] + beta * sum(self.points[w] for w in near)
        faces = sum(self.centroid(f) for f in self.round[v]) / n
        middles = sum((self.points[v] + self.points[w]) / 2 for w in near) / n
        return (faces + 2 * middles + (n - 3) * self.points[v]) / n

    def point_by_rule(self, v, less):
        """The vertex's point by the rule that holds when all sharpness is less by so much."""
        sharp = [w for w in self.neighbours(v) if self.edges.get(frozenset((v, w)), 0) > less]
        if self.vertices.get(v, 0) > less or len(sharp) > 2:
            return self.points[v]
        if len(sharp) == 2:
            return 3 / 4 * self.points[v] + sum(self.points[w] for w in sharp) / 8
        return self.smooth_point(v)

    def vertex_point(self, v):
        tags = [self.edges.get(frozenset((v, w)), 0) for w in self.neighbours(v)] + [self.vertices.get(v, 0)]
        expiring = [s for s in tags if 0 < s <= 1]
        present = sum(expiring) / len(expiring) if expiring else 1
        return present * self.point_by_rule(v, 0) + (1 - present) * self.point_by_rule(v, 1)

    def refined(self, edge_order):
        """The next level: vertices keep their numbers, then middles in the given order of edges, then centroids."""
        n = len(self.points)
        middle = {edge: n + e for e, edge in enumerate(edge_order)}
        points = [self.vertex_point(v) for v in range(n)] + [self.edge_point(edge) for edge in edge_order]
        faces = []
        for f, face in enumerate(self.faces):
            around = [middle[frozenset((a, b))] for a, b in zip(face, face[1:] + face[:1], strict=True)]
            corners = [[v, around[i], around[i - 1]] for i, v in enumerate(face)]
            if self.scheme == "loop":
                faces += [*corners, around]
            else:
                centre = n + len(edge_order) + f
                faces += [[v, after, centre, before] for v, after, before in corners]
        if self.scheme != "loop":
            points += [self.centroid(f) for f in range(len(self.faces))]
        halves = {frozenset((v, middle[edge])): s - 1 for edge, s in self.edges.items() if s > 1 for v in edge}
        return Reference(self.scheme, faces, points, halves, {v: s - 1 for v, s in self.vertices.items() if s > 1})


@pytest.mark.parametrize(("scheme", "name"), SEMI)
def test_refinement_follows_the_uniform_rule(scheme, name):
    mesh = mesh_of(name)
    reference, t, points = Reference.of(scheme, mesh), mesh.topology, mesh.points
    for _ in range(3):
        step = SCHEMES[scheme].refine(t)
        reference = reference.refined([frozenset(ends) for ends in t.edge_vertices.tolist()])
        t, by_kernel, points = step.child, step.refined(points), step.matrix @ points
        np.testing.assert_allclose(points, reference.points, atol=1e-13)
        np.testing.assert_allclose(by_kernel, reference.points, atol=1e-13)
        sharp = {frozenset(e): s for e, s in zip(t.edge_vertices.tolist(), t.sharpness, strict=True) if s > 0}
        assert sharp == reference.edges
        assert {v: s for v, s in enumerate(t.corner_sharpness) if s > 0} == reference.vertices


def crossed(scheme, sharpness, pinned=None):
    """An open square with a crease across, and a corner."""
    t = mesh_of("disc" if scheme == "loop" else "quad disc").topology
    corners = {} if pinned is None else {"corner_vertices": [16], "corner_sharpness": [pinned]}
    return Topology.from_faces(
        t.face_offsets,
        t.face_vertices,
        t.vertex_count,
        crease_edges=CHAIN,
        crease_sharpness=np.full(len(CHAIN), sharpness),
        **corners,
    )


@pytest.mark.parametrize("scheme", BOTH)
@pytest.mark.parametrize("levels", [1, 2, 3])
def test_whole_sharpness_is_sharp_for_so_many_levels_and_then_smooth(scheme, levels):
    rules = SCHEMES[scheme]
    semi, sharp = crossed(scheme, float(levels), float(levels)), crossed(scheme, 10.0, 10.0)
    limit = np.eye(semi.vertex_count)
    for _ in range(levels):
        steps = rules.refine(semi), rules.refine(sharp)
        np.testing.assert_array_equal(steps[0].matrix.toarray(), steps[1].matrix.toarray())
        semi, sharp, limit = steps[0].child, steps[1].child, steps[0].matrix @ limit
    assert not len(semi.crease_edges)
    assert not semi.corner_sharpness.any()
    assert len(sharp.crease_edges) == 4 * 2**levels
    plain = Topology.from_faces(semi.face_offsets, semi.face_vertices, semi.vertex_count)
    later = (rules.limit_rows(plain) @ limit)[: len(limit[0])]
    np.testing.assert_allclose(rules.limit_rows(crossed(scheme, levels, levels)).toarray(), later, atol=1e-15)


@pytest.mark.parametrize("scheme", BOTH)
def test_ten_and_more_is_for_ever(scheme):
    ten, more = crossed(scheme, 10.0, 12.5), crossed(scheme, np.inf, np.inf)
    np.testing.assert_array_equal(ten.sharpness, more.sharpness)
    np.testing.assert_array_equal(ten.corner_sharpness, more.corner_sharpness)
    almost = crossed(scheme, 9.5)
    assert np.isfinite(almost.sharpness[almost.crease_edges]).all()


@pytest.mark.parametrize("scheme", BOTH)
def test_the_surface_is_continuous_in_the_sharpness(scheme):
    """Between two levels all weights change with the fraction; at whole sharpness nothing jumps."""
    points = mesh_of("disc" if scheme == "loop" else "quad disc").points
    for whole in (1.0, 2.0):
        below, at, above = (
            LimitSurface(ControlMesh(crossed(scheme, whole + d, whole + d), points), scheme).vertex_limits()
            for d in (-1e-7, 0.0, 1e-7)
        )
        assert np.abs(below - at).max() < 1e-6
        assert np.abs(above - at).max() < 1e-6


@pytest.mark.parametrize("scheme", BOTH)
def test_sharper_creases_come_nearer_to_the_sharp_one(scheme):
    points = mesh_of("disc" if scheme == "loop" else "quad disc").points
    points = points + np.where(np.isin(np.arange(25), [10, 11, 12, 13, 14]), 1.0, 0.0)[:, None] * [0, 0, 1]
    gap = []
    sharp = LimitSurface(ControlMesh(crossed(scheme, 10.0), points), scheme).vertex_limits()
    for s in (0.0, 0.5, 1.0, 1.5, 2.0, 3.0):
        soft = LimitSurface(ControlMesh(crossed(scheme, s), points), scheme).vertex_limits()
        gap.append(np.abs(soft - sharp)[12].max())
    assert (np.diff(gap) < 0).all()


@pytest.mark.parametrize(("scheme", "name"), SEMI)
def test_every_cell_that_a_semi_sharp_tag_touches_is_cut(scheme, name):
    """No single patch can hold rules that change."""
    surface = surface_of(scheme, name)
    t, table = surface.topology, surface.compiled.table
    cut = np.flatnonzero(table.cell_node < 0)
    touched = np.zeros(t.vertex_count, bool)
    touched[t.edge_vertices[np.isfinite(t.sharpness) & (t.sharpness > 0)]] = True
    touched |= np.isfinite(t.corner_sharpness) & (t.corner_sharpness > 0)
    corners = surface.domain.vertex
    near = np.where(corners >= 0, touched[corners], False).any(axis=1)
    assert np.isin(np.flatnonzero(near), cut).all()

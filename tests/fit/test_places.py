"""Where the control mesh lies on the cells: laws that hold for every scheme that takes polygons."""

import numpy as np
import pytest

from shapes.zoo import icosahedron_data
from subdfit.fit.places import Places
from subdfit.limit import LimitSurface
from subdfit.mesh.control_mesh import ControlMesh
from subdfit.mesh.data import MeshData
from subdfit.schemes import SCHEMES

POLYGONS = [name for name, scheme in SCHEMES.items() if scheme.faces == "polygons"]


def sheet(triangle: bool) -> ControlMesh:
    """A bumpy 4 x 3 sheet of quads with a crease through it, one quad cut in two if asked."""
    x, y = (a.ravel() for a in np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij"))
    points = np.column_stack([x, y, 0.3 * np.sin(x) * np.cos(y)])
    quads = [[4 * i + j, 4 * i + 4 + j, 4 * i + 5 + j, 4 * i + 1 + j] for i in range(4) for j in range(3)]
    faces = [quads[0][:3], [quads[0][0], *quads[0][2:]], *quads[1:]] if triangle else quads
    offsets = np.concatenate([[0], np.cumsum([len(f) for f in faces])])
    crease = np.column_stack([np.arange(8, 11), np.arange(9, 12)])
    return ControlMesh.from_data(
        MeshData(points, offsets, np.concatenate(faces), crease_edges=crease, crease_sharpness=np.full(3, np.inf))
    )


SURFACES = [
    *((name, sheet(triangle)) for name in POLYGONS for triangle in (True, False)),
    *((name, ControlMesh.from_triangles(*icosahedron_data())) for name in SCHEMES),
]
EVERY = pytest.mark.parametrize(("scheme", "mesh"), SURFACES)


@EVERY
def test_both_sides_of_an_edge_have_the_same_middle(scheme: str, mesh: ControlMesh) -> None:
    t = mesh.topology
    inner = np.flatnonzero(t.twin >= 0)
    places = Places(LimitSurface(mesh, scheme))
    np.testing.assert_allclose(places.middles(inner), places.middles(t.twin[inner].astype(np.int64)), atol=1e-12)


@EVERY
def test_middles_and_centres_lie_near_their_ends(scheme: str, mesh: ControlMesh) -> None:
    t = mesh.topology
    places = Places(LimitSurface(mesh, scheme))
    limits = places.vertices()
    length = np.linalg.norm(mesh.points[t.face_vertices] - mesh.points[t.face_vertices[t.following]], axis=1)
    between = (limits[t.face_vertices] + limits[t.face_vertices[t.following]]) / 2
    assert np.all(np.linalg.norm(places.middles(np.arange(len(t.twin))) - between, axis=1) < 0.4 * length)
    middle = np.array([limits[t.face_vertices[t.face == f]].mean(axis=0) for f in range(t.face_count)])
    assert np.linalg.norm(places.centres(np.arange(t.face_count)) - middle, axis=1).max() < 0.6


@EVERY
def test_sharp_sides_of_cells_lie_on_sharp_edges(scheme: str, mesh: ControlMesh) -> None:
    surface = LimitSurface(mesh, scheme)
    t, domain = mesh.topology, surface.domain
    places = Places(surface)
    cell, side = np.nonzero(domain.sharp & domain.present)
    edge = t.edge[places.side[cell, side]]
    assert np.all(np.isinf(t.sharpness[edge]))
    assert set(edge) == set(np.flatnonzero(np.isinf(t.sharpness)))
    assert np.all(t.face[places.side[cell, side]] == places.face[cell])


@EVERY
def test_shares_of_corners_are_means_of_their_face(scheme: str, mesh: ControlMesh) -> None:
    surface = LimitSurface(mesh, scheme)
    places, t = Places(surface), mesh.topology
    shares = places.corner_shares.toarray()
    corner = surface.domain.points
    cell, slot = np.nonzero(surface.domain.present)
    np.testing.assert_allclose(shares[corner[cell, slot]].sum(axis=1), 1.0)
    for c, s in zip(cell, slot, strict=True):
        assert set(np.flatnonzero(shares[corner[c, s]])) <= set(t.face_vertices[t.face == places.face[c]])

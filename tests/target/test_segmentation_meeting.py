"""Borders of a noisy box with teeth are moved back to its edges."""

import numpy as np
import trimesh

from subdfit.target.features import edges_among, mesh_edges
from subdfit.target.segmentation_meeting import where_faces_meet

NOISE = 0.005


def test_teeth_of_borders_go_back():
    mesh = trimesh.creation.box().subdivide().subdivide().subdivide().subdivide()
    points, triangles = np.array(mesh.vertices), np.asarray(mesh.faces)
    side = np.argmax(np.abs(mesh.face_normals), axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    edges = mesh_edges(points, triangles)
    sharp = edges.vertices[edges.angle > 45]
    labels = side.copy()
    # Every other triangle along the edges of the top goes to the face beside it.
    beside = edges.faces[edges_among(edges.vertices, sharp)]
    top = np.isin(side[beside], 5)
    chosen = beside[top.any(axis=1)][::4]
    labels[chosen[side[chosen] == 5]] = side[chosen[side[chosen] != 5]]
    assert np.count_nonzero(labels != side) > 10
    between = (edges.valence == 2) & (labels[edges.faces[:, 0]] != labels[edges.faces[:, 1]])
    noisy = points + NOISE * np.random.default_rng(0).normal(size=points.shape)
    found, features = where_faces_meet(noisy, triangles, labels, edges.vertices[between], NOISE)
    np.testing.assert_array_equal(found, side)
    np.testing.assert_array_equal(np.sort(features, axis=0), np.sort(sharp, axis=0))

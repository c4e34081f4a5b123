"""Tiny hard control meshes of triangles and quads together, for schemes that take both: see `shapes.zoo`."""

from functools import partial

import numpy as np

from shapes.polygons import extruded_data, polygons, prism_data
from shapes.zoo import Shape, circle


def mixed_fan_data(order, close=True):
    """Faces round vertex 0, T or Q; its neighbours come first, then the far corners of quads."""
    edges = len(order) if close else len(order) + 1
    turn = circle(edges) if close else circle(2 * edges)[:edges]
    points, faces = [[0, 0, 0.4], *turn], []
    for i, letter in enumerate(order):
        a, b = 1 + i, 1 + (i + 1) % edges
        if letter == "Q":
            points.append(0.8 * (turn[i] + turn[(i + 1) % edges]) - [0, 0, 0.1])
        faces.append([0, a, b] if letter == "T" else [0, a, len(points) - 1, b])
    return np.array(points), faces


def mixed_fan(order, **tags):
    """An inner vertex whose faces come in the given order."""
    return polygons(mixed_fan_data(order), f"mixed fan {order}", **tags)


def mixed_half_fan(order, **tags):
    """A boundary vertex whose faces come in the given order."""
    return polygons(mixed_fan_data(order, close=False), f"mixed half fan {order}", **tags)


def ladder_data(rows, columns, close_rows=False, close_columns=False):
    """A grid whose rows of cells are quads (Q) or cut in two triangles (T), closed or open either way."""
    height, width = len(rows) + (not close_rows), columns + (not close_columns)
    faces = []
    for i, letter in enumerate(rows):
        for j in range(columns):
            a, b = i * width + j, i * width + (j + 1) % width
            c, d = (i + 1) % height * width + (j + 1) % width, (i + 1) % height * width + j
            faces += [[a, b, c], [a, c, d]] if letter == "T" else [[a, b, c, d]]
    y, x = (v.ravel().astype(float) for v in np.mgrid[:height, :width])
    return np.stack([x, y, 0.1 * x * y], 1), faces


def ladder(rows, columns, **tags):
    """An open patchwork: seams run from boundary to boundary."""
    return polygons(ladder_data(rows, columns), f"ladder {rows} {columns}", **tags)


def mixed_torus(rows, columns, **tags):
    """A torus of rows of quads and of triangles: all seams regular."""
    points, faces = ladder_data(rows, columns, True, True)
    s, t = 2 * np.pi * points[:, 1] / len(rows), 2 * np.pi * points[:, 0] / columns
    points = np.stack([(3 + np.cos(s)) * np.cos(t), (3 + np.cos(s)) * np.sin(t), np.sin(s)], 1)
    return polygons((points, [face[::-1] for face in faces]), f"mixed torus {rows} {columns}", **tags)


def cut_some(faces, seed):
    """Cut every second quad, strewn at random, in two triangles."""
    random = np.random.default_rng(seed)
    out = []
    for face in faces:
        turned = list(np.roll(face, random.integers(4)))
        cut = len(face) == 4 and random.random() < 0.5
        out += [turned[:3], [turned[0], turned[2], turned[3]]] if cut else [turned]
    return out


def seam_sphere(seed, **tags):
    """A cube, some of whose faces are cut: seams and mixed valences all over a sphere."""
    points, faces = prism_data(4)
    return polygons((points, cut_some(faces, seed)), f"seam sphere {seed}", **tags)


def mixed_extruded(seed, **tags):
    points, faces = extruded_data()
    return polygons((points, cut_some(faces, seed)), f"mixed extruded {seed}", **tags)


def mixed_tagged(seed, sharpness=np.inf):
    """Creases strewn at random over triangles and quads, and two corners; all sharp for ever, or semi-sharp."""
    t = mixed_extruded(seed).topology
    random = np.random.default_rng(seed)
    edges = t.edge_vertices[random.random(t.edge_count) < 0.2]
    corners = random.choice(t.vertex_count, 2, replace=False)
    return mixed_extruded(
        seed,
        crease_edges=edges,
        crease_sharpness=random.uniform(0.3, 1, len(edges)) * sharpness,
        corner_vertices=corners,
        corner_sharpness=[sharpness, 0.6 * sharpness],
    )


def chain(*vertices):
    return np.column_stack([vertices[:-1], vertices[1:]]).tolist()


ORDERS = ["QTT", "QQT", "QTTT", "QTQT", "QQQT", "TTQTQ", "TTTTTQ", "QQTQTTQT"]
"""Mixed orders of three faces to eight; TTTQQ, the regular seam, is all over the ladders."""

MIXED: dict[str, Shape] = {
    **{f"mixed fan {order}": partial(mixed_fan, order) for order in ORDERS},
    **{f"mixed half fan {order}": partial(mixed_half_fan, order) for order in ("QT", "TTQ", "QQTT")},
    "ladder QQTTT": partial(ladder, "QQTTT", 5),
    "ladder QTQ": partial(ladder, "QTQ", 4),
    "mixed torus QQTT": partial(mixed_torus, "QQTT", 5),
    **{f"seam sphere {seed}": partial(seam_sphere, seed) for seed in (1, 4)},
    "mixed extruded 0": partial(mixed_extruded, 0),
    "crease along a seam": partial(ladder, "QQTT", 5, crease_edges=chain(*range(12, 18))),
    "crease across a seam": partial(ladder, "QQTT", 4, crease_edges=chain(2, 7, 12, 17, 22)),
    "dart along a seam": partial(ladder, "QQTT", 5, crease_edges=chain(12, 13, 14)),
    "dart across a seam": partial(ladder, "QQTT", 4, crease_edges=chain(2, 7, 12)),
    "dart beside a seam": partial(ladder, "QQQTTT", 4, crease_edges=chain(2, 7, 12)),
    "corner on a seam": partial(ladder, "QQTT", 4, corner_vertices=[12, 10]),
    **{
        f"mixed dart {order}": partial(mixed_fan, order, crease_edges=[[0, 1]]) for order in ("TTTQQ", "QTQT", "TTQQTQ")
    },
    **{
        f"mixed parted {order}": partial(mixed_fan, order, crease_edges=[[0, 1], [0, 3]])
        for order in ("TTTQQ", "TQQTQ", "QTTTQQ")
    },
    "mixed star": partial(mixed_fan, "TQTQQT", crease_edges=[[0, 1], [0, 2], [0, 5]]),
    "mixed tagged 0": partial(mixed_tagged, 0),
    "mixed semi": partial(mixed_tagged, 2, 2.4),
}

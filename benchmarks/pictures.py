"""The pictures of these pages that show fits and faces; that of whole parts is `parts_figure`'s."""

import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

import subdfit
from benchmarks.common import MODELS
from benchmarks.parts_figure import EDGE
from subdfit.api.pictures import control_edges
from subdfit.draw.camera import camera_for
from subdfit.draw.fit_picture import SURFACE
from subdfit.draw.gallery import Panel, gallery
from subdfit.draw.history_picture import histories_picture
from subdfit.draw.region_picture import region_colors
from subdfit.target.features import mesh_edges

ARMADILLO = {"max_error": "0.248%", "rms_error": "0.0618%", "control_vertices": 433, "creases": "none"}
BUNNY = {"max_error": "0.049%", "rms_error": "0.0108%", "control_vertices": 612, "creases": "none"}
"""What the paper's Table 1 asks of its models."""
FITS = {
    "bunny": ("bunny", BUNNY),
    "armadillo": ("armadillo_50k", ARMADILLO),
    "dragon": ("dragon", {"max_error": "0.05%", "creases": "none"}),
    "igea": ("igea", {"max_error": "0.05%", "mean_error": "0.01%", "control_vertices": 1343, "creases": "none"}),
    "fandisk": ("fandisk", {"max_error": "0.1%"}),
    "block-lavoue": ("block", {"max_error": "1%", "scheme": "quad-triangle", "method": "lavoue"}),
}
"""Pictures of one fit each: its model, what is asked."""
METHODS = ("geometric", "auto")
SCHEMES = ("loop", "catmull-clark", "doo-sabin", "quad-triangle")
LEVEL = 3
SIDES = {"fandisk": (122.0, 35.0), "casting": (32.0, 35.0), "block": (32.0, 20.0)}
"""Parts whose faces are shown, and from where."""


def draw(folder: Path) -> None:
    """Write all pictures into a folder."""
    for name, (part, asked) in FITS.items():
        found = subdfit.fit(MODELS / f"{part}.ply", **asked)
        subdfit.picture(folder / f"{name}.png", found)
        print(f"{name}: {found.control_mesh.topology.vertex_count} control vertices", flush=True)
    convergence(folder / "armadillo-convergence.png")
    gallery(folder / "armadillo-sides.png", sides(), panel_width=3.2)
    gallery(folder / "schemes.png", [fitted(part, scheme) for part in ("rocker-arm", "holes") for scheme in SCHEMES],
            columns=4, panel_width=3.6)  # fmt: skip
    gallery(folder / "faces.png", [faces(part, *side) for part, side in SIDES.items()], panel_width=4.0)


def convergence(path: Path) -> None:
    """Figure 5 of Nishiyama et al. 2008, by both methods: errors and seconds by iteration on the armadillo."""
    found = [subdfit.fit(MODELS / "armadillo_50k.ply", method=method, **ARMADILLO) for method in METHODS]
    histories = [(method, [asdict(row) for row in fit.history]) for method, fit in zip(METHODS, found, strict=True)]
    histories_picture(path, histories, tolerance=found[0].settings.tolerance.max)


def sides() -> list[Panel]:
    """Figure 8 of the same paper: the armadillo and its surface, from the front and from behind."""
    found = subdfit.fit(MODELS / "armadillo_50k.ply", **ARMADILLO)
    shown, target = found.surface.tessellate(LEVEL), found.target
    whole = target.points, target.triangles
    views = [camera_for(*whole, azimuth=azimuth) for azimuth in (212.0, 32.0)]
    smooth = f"surface of {found.control_mesh.topology.vertex_count:,} control vertices"
    return [
        *(Panel(*whole, f"scan of {len(whole[0]):,} points", camera=camera) for camera in views),
        *(Panel(shown.points, shown.triangles, smooth, colors=SURFACE, camera=camera) for camera in views),
    ]


def fitted(part: str, scheme: str) -> Panel:
    """The control mesh of a fit at .15 % on its limit surface."""
    found = subdfit.fit(MODELS / f"{part}.ply", scheme=scheme, max_error="0.15%")
    shown, count = found.surface.tessellate(LEVEL), found.control_mesh.topology.vertex_count
    lines = control_edges(found.surface, 2**LEVEL)
    caption = f"{scheme}: {count:,} control vertices" + (", certified" if found.certified else "")
    return Panel(shown.points, shown.triangles, caption, colors=SURFACE, lines=lines, line_colors=EDGE,
                 camera=camera_for(shown.points, shown.triangles))  # fmt: skip


def faces(part: str, azimuth: float, elevation: float) -> Panel:
    """A part's faces, each in a colour, seen from a side given in degrees."""
    found = subdfit.segment(MODELS / f"{part}.ply")
    edges = mesh_edges(found.points, found.triangles)
    sides = found.labels[edges.faces]
    smooth = edges.vertices[(edges.valence == 2) & (sides[:, 0] != sides[:, 1])]
    lines = np.concatenate([found.points[smooth], found.points[found.feature_edges]])
    ink = np.repeat([[0.95, 0.95, 0.95], [0.08, 0.09, 0.1]], [len(smooth), len(found.feature_edges)], axis=0)
    return Panel(found.points, found.triangles, f"{part}: {found.labels.max() + 1} faces", lines=lines,
                 colors=region_colors(found.labels), line_colors=ink, line_width=0.8,
                 camera=camera_for(found.points, found.triangles, azimuth=azimuth, elevation=elevation))  # fmt: skip


if __name__ == "__main__":
    draw(Path(sys.argv[1] if len(sys.argv) > 1 else "."))

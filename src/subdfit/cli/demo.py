"""``subdfit demo``: the main job on a model that comes with the program, or on the user's own."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subdfit.cli import options
from subdfit.cli.ahead import compiling_ahead
from subdfit.cli.console import Console, say
from subdfit.cli.fit import EXIT, add_writing, fit_arguments
from subdfit.cli.outputs import check_outputs, made_folder, write_json, write_surface
from subdfit.cli.summary import fit_line, picture_title

if TYPE_CHECKING:
    from subdfit import FitResult

SCAN = "scan.ply"
FILES = {
    "control_mesh.obj": "the control mesh, with its scheme and creases",
    "limit_surface.stl": "the limit surface, tessellated",
    "limit_surface.glb": "the same with smooth normals, for viewers",
    "result.json": "errors, seconds, settings and history",
    "picture.png": "target, control mesh and error colours",
    "history.png": "errors, control vertices and seconds by iteration",
}
"""What the demo writes, and what each is."""


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "demo",
        help="the main job on a built-in model, with pictures",
        description="Fit a control mesh to a built-in synthetic scan, or to PATH, and show what came out.",
        allow_abbrev=False,
    )
    parser.add_argument("path", metavar="PATH", nargs="?", help="a dense mesh of your own (default: a synthetic scan)")
    parser.add_argument(
        "-o", "--output", metavar="DIR", default="subdfit-demo", help="folder to write into (default: subdfit-demo)"
    )
    options.add_tolerances(parser, "default: a largest error of 0.1%")
    options.add_target_options(parser)
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="of the synthetic scan (default: 0)")
    options.add_machine_options(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Fit, write the folder, print what is in it."""
    from subdfit import api

    folder = made_folder(args.output)
    names = [*FILES] if args.path else [SCAN, *FILES]
    check_outputs([], [args.path] if args.path else [], documents=[str(folder / name) for name in names])
    target = args.path or _scan(folder, args, console)
    with compiling_ahead("loop", args.threads, args.memory):
        result = api.fit(target, progress=console.progress, **fit_arguments(args))
    console.stage("writing and drawing")
    _write(folder, result)
    console.rest()
    say(f"\nin {folder}:")
    for name in names:
        say(f"  {name:<18} {FILES.get(name, 'the synthetic scan that was fitted')}")
    say(f"\n{fit_line(result)}")
    return EXIT[result.status]


def _scan(folder: Path, args: argparse.Namespace, console: Console) -> str:
    """Make the built-in model and write it where the user finds it."""
    from subdfit import api
    from subdfit.target.synthetic_scan import synthetic_scan

    console.stage("making the synthetic scan")
    path = str(folder / SCAN)
    points, triangles = synthetic_scan(args.seed)
    api.write(path, api.mesh_data((points, triangles)))
    say(f"The model is synthetic: made by formula, {len(points):,} points with noise, no scanner was involved.")
    args.unit = args.unit or "mm"
    return path


def _write(folder: Path, result: "FitResult") -> None:
    from subdfit import api

    clock = time.perf_counter()
    for name in ("control_mesh.obj", "limit_surface.stl", "limit_surface.glb"):
        write_surface(str(folder / name), result.control_mesh, result.surface, None)
    api.picture(folder / "picture.png", result, title=picture_title(result))
    api.history_picture(folder / "history.png", result, title="Convergence")
    add_writing(result, clock)
    write_json(folder / "result.json", result.to_dict())

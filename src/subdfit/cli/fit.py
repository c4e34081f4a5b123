"""``subdfit fit``: a control mesh within tolerance of a target."""

import argparse
import time
from typing import TYPE_CHECKING, Any

from subdfit.cli import options
from subdfit.cli.ahead import compiling_ahead
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import check_level, check_outputs, write_json, write_surface
from subdfit.cli.saved_run import check_run, write_run
from subdfit.cli.summary import fit_line, picture_title
from subdfit.wording import counted

if TYPE_CHECKING:
    from subdfit import FitResult

EXIT = {"within_tolerance": 0, "best_effort": 1, "interrupted": 130}

_EXAMPLES = """examples:
  subdfit fit bunny.ply -o cage.obj
  subdfit fit part.stl -o cage.obj -o surface.glb --max-error 0.02 --unit mm --creases 30 --picture part.png
  subdfit fit part.stl -o cage.obj --scheme quad-triangle --method lavoue
"""


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "fit",
        help="dense mesh or points -> control mesh within tolerance",
        description="Fit a light control mesh whose limit surface lies within a tolerance of a dense mesh or "
        "of points.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "target", metavar="TARGET", help="dense mesh: .ply .obj .off .stl .glb .gltf .json; points: .ply .xyz"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="OUT",
        action="append",
        required=True,
        help="file to write, may be repeated: .obj .ply .json .off hold the control mesh, .stl .glb the tessellated "
        "limit surface",
    )
    options.add_tolerances(parser, "default: a largest error of 0.1%")
    _add_method(parser)
    options.add_target_options(parser)
    group = parser.add_argument_group("what else to write")
    group.add_argument("--tessellate", metavar="LEVEL", type=int, help="tessellate the limit surface in every output")
    group.add_argument("--json", metavar="FILE", help="errors, seconds, settings and history")
    group.add_argument("--picture", metavar="FILE.png", help="target, control mesh, error colours")
    group.add_argument("--plot", metavar="FILE.png", help="errors, control vertices and seconds by iteration")
    group.add_argument(
        "--run",
        metavar="DIR",
        dest="saved_run",
        help="folder for the saved run: control mesh, errors of all points, settings, history",
    )
    options.add_machine_options(parser)
    parser.set_defaults(run=run)


def _add_method(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("the fit")
    group.add_argument("--scheme", choices=options.SCHEMES, default="loop", help="subdivision scheme (default: loop)")
    group.add_argument(
        "--method",
        choices=options.METHODS,
        default="auto",
        help="tangent: tangent distances; geometric: Nishiyama, Morioka and Maekawa 2008; lavoue: Lavoué, Dupont and "
        "Baskurt 2007, from the faces and edges of a part (schemes quad-triangle, catmull-clark); auto: lavoue for "
        "parts with many sharp edges by these schemes, where it is certified, else tangent (default)",
    )
    group.add_argument("--control-vertices", metavar="N", type=int, help="vertices to start from (default: chosen)")
    group.add_argument("--max-control-vertices", metavar="N", type=int, help="stop at so many, with the best so far")
    group.add_argument(
        "--boundary",
        choices=("fit", "fixed"),
        default="fit",
        help="fit the boundary with the rest, or first and then hold it (default: fit)",
    )
    group.add_argument(
        "--thin",
        action="store_true",
        help="in the end remove control vertices and merge faces while the tolerance holds: a lighter control mesh in "
        "several times the time; the method lavoue does so in any case",
    )
    group.add_argument(
        "--robust",
        metavar="SHARE",
        help="share of the points that may be left out as outliers; they are listed (default: 0.5%% of a cloud, 0 of a "
        "mesh)",
    )
    group.add_argument("--seed", metavar="N", type=int, default=0, help="of random numbers; no method draws any today")
    group = parser.add_argument_group("the method geometric")
    group.add_argument(
        "--over-relaxation", metavar="FACTOR", type=float, default=1.0, help="on displacements, below 2 (default: 1)"
    )
    group.add_argument("--nesterov", action="store_true", help="accelerate by Nesterov's momentum")
    group.add_argument(
        "--no-boundary-step",
        dest="boundary_step",
        action="store_false",
        help="boundary data pull as all others do, as in the paper",
    )


def run(args: argparse.Namespace, console: Console) -> int:
    """Fit, write all outputs, print the summary."""
    from subdfit import api

    check_level(args.tessellate)
    check_outputs(args.output, [args.target], documents=[args.json], pictures=[args.picture, args.plot])
    check_run(args.saved_run)
    try:
        with compiling_ahead(args.scheme, args.threads, args.memory):
            result = api.fit(args.target, progress=console.progress, **fit_arguments(args))
    except KeyboardInterrupt:
        return _write_unmeasured(args, console)
    write_all(args, result, console)
    console.rest()
    say(fit_line(result))
    return EXIT[result.status]


def fit_arguments(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments of `subdfit.fit` for the options that a command has; the library knows the others' defaults."""
    names = ("scheme", "method", "control_vertices", "max_control_vertices", "boundary", "thin", "robust", "seed")
    geometric = ("over_relaxation", "nesterov", "boundary_step")
    given = {name: getattr(args, name) for name in (*names, *geometric) if hasattr(args, name)}
    return options.target_arguments(args) | given


def write_all(args: argparse.Namespace, result: "FitResult", console: Console) -> None:
    """Write every output; the JSON document last, as it tells the seconds of all."""
    from subdfit import api

    clock = time.perf_counter()
    console.stage("writing")
    for path in args.output:
        write_surface(path, result.control_mesh, result.surface, args.tessellate)
    if args.picture:
        api.picture(args.picture, result, title=picture_title(result))
    if args.plot:
        api.history_picture(args.plot, result, title="Convergence")
    add_writing(result, clock)
    if args.saved_run:
        write_run(args.saved_run, result)
    if args.json:
        write_json(args.json, result.to_dict())


def add_writing(result: "FitResult", since: float) -> None:
    """Add the seconds since writing began to the result's."""
    writing = time.perf_counter() - since
    result.seconds["write"] = writing
    result.seconds["total"] += writing


def _write_unmeasured(args: argparse.Namespace, console: Console) -> int:
    """Write the best control mesh seen, when Ctrl-C came again while it was being measured."""
    from subdfit import api

    if console.best is None:
        raise KeyboardInterrupt
    for path in args.output:
        write_surface(path, console.best, api.LimitSurface(console.best), args.tessellate)
    console.rest()
    others = {"--json": args.json, "--picture": args.picture, "--plot": args.plot, "--run": args.saved_run}
    left_out = "".join(f"; {option} not written" for option, path in others.items() if path)
    vertices = counted(console.best.topology.vertex_count, "control vertex")
    say(f"{vertices}, interrupted before they were measured{left_out}")
    return EXIT["interrupted"]

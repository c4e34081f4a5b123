"""``subdfit interpolate``: a control mesh whose limit surface passes through every vertex of a mesh."""

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import DRAWN, check_outputs, write_json, write_surface
from subdfit.wording import counted

if TYPE_CHECKING:
    from subdfit.api import InterpolationResult

EXIT = {"within_tolerance": 0, "best_effort": 1, "interrupted": 130}


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "interpolate",
        help="control mesh whose limit surface passes through every vertex of a mesh",
        description="Find the control mesh whose limit surface passes through every vertex of a mesh; its vertices are "
        "the mesh's, in the same order.",
        allow_abbrev=False,
    )
    parser.add_argument("mesh", metavar="MESH", help="mesh to interpolate")
    parser.add_argument(
        "-o", "--output", metavar="OUT", action="append", required=True, help="file to write, may be repeated"
    )
    options.add_scheme(parser)
    parser.add_argument(
        "--method",
        choices=options.INTERPOLATION_METHODS,
        default="cg",
        help="cg: corners, curves, then conjugate gradients (default); progressive: Cheng et al., as printed; "
        "over-relaxation, chebyshev: that iteration with better factors",
    )
    parser.add_argument(
        "--mask",
        choices=("original", "averaging"),
        default="original",
        help="for doo-sabin: its own mask (default), or the averaging one of Cheng et al.",
    )
    parser.add_argument(
        "--fair",
        action="store_true",
        help="refine once and take the surface of least thin-plate energy through all vertices (fewer ripples)",
    )
    options.add_creases(parser)
    parser.add_argument(
        "--tolerance",
        metavar="SHARE",
        type=float,
        default=1e-12,
        help="largest distance of a vertex from the surface, as a share of the diagonal (default: 1e-12)",
    )
    parser.add_argument("--keep-components", metavar="N", type=int, help="interpolate the N largest components only")
    parser.add_argument("--json", metavar="FILE", help="errors, seconds, and the largest error at each iteration")
    parser.add_argument("--picture", metavar="FILE.png", help="the points, the mesh, and the surface through them")
    parser.add_argument("--unit", metavar="NAME", help="name of the mesh's unit, for messages")
    parser.add_argument("--threads", metavar="N", type=int, help="threads to use (default: one a core)")
    options.add_quiet(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Interpolate, write, and say how near the surface comes."""
    from subdfit import api

    check_outputs(args.output, [args.mesh], documents=[args.json], pictures=[args.picture])
    names = ("scheme", "mask", "method", "fair", "creases", "keep_components", "tolerance", "unit", "threads")
    result = api.interpolate(args.mesh, **{name: getattr(args, name) for name in names})
    clock = time.perf_counter()
    console.stage("writing")
    for path in args.output:
        if Path(path).suffix.lower() in DRAWN:
            write_surface(path, result.control_mesh, result.surface, None)
        else:
            api.write(path, result.control_mesh)
    if args.picture:
        api.picture(args.picture, result)
    result.seconds["write"] = time.perf_counter() - clock
    result.seconds["total"] += result.seconds["write"]
    if args.json:
        write_json(args.json, result.to_dict())
    console.rest()
    say(_line(result))
    return EXIT[result.status]


def _line(result: "InterpolationResult") -> str:
    """One line on an interpolation."""
    sharp = result.to_dict()["crease_edges"]
    creases = f" with {counted(sharp, 'crease edge')}" if sharp else ""
    reached = "" if result.status == "within_tolerance" else ", tolerance not reached"
    energy = "thin-plate energy {:.4g} instead of {:.4g}, ".format(*result.energy[::-1]) if result.energy else ""
    return (
        f"{counted(result.control_mesh.topology.vertex_count, 'control vertex')}{creases}, "
        f"largest relative error {result.distances.max():.2g}{reached}, {energy}"
        f"{counted(result.iterations, 'iteration')}, {result.seconds['total']:.1f} s"
    )

"""``subdfit subdivide``: a control mesh refined."""

import argparse
from typing import Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import check_outputs
from subdfit.wording import counted


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "subdivide",
        help="refine a control mesh",
        description="Refine a control mesh, its creases and corners with it.",
        allow_abbrev=False,
    )
    parser.add_argument("cage", metavar="CAGE", help="control mesh")
    parser.add_argument(
        "-o", "--output", metavar="OUT", action="append", required=True, help="file to write, may be repeated"
    )
    parser.add_argument("--levels", metavar="N", type=int, default=1, help="how many times (default: 1)")
    parser.add_argument("--limit", action="store_true", help="put the refined vertices on the limit surface")
    options.add_scheme(parser)
    options.add_quiet(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Refine and write."""
    from subdfit import api

    check_outputs(args.output, [args.cage])
    console.stage("subdividing")
    mesh = api.subdivide(args.cage, args.levels, args.scheme, limit=args.limit)
    for path in args.output:
        api.write(path, mesh)
    console.rest()
    say(f"{counted(mesh.topology.vertex_count, 'vertex')}, {counted(mesh.topology.face_count, 'face')}")
    return 0

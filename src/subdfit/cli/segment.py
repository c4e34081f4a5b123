"""``subdfit segment``: the faces of a part, and its feature edges."""

import argparse
from pathlib import Path
from typing import Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import check_outputs
from subdfit.errors import InputError
from subdfit.wording import counted


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "segment",
        help="the faces of a part, and its feature edges",
        description="Find the faces of a part: regions of like curvature between sharp edges. The PLY file holds the "
        "mesh with a face property 'label', and the feature edges as an element 'edge'.",
        allow_abbrev=False,
    )
    parser.add_argument("mesh", metavar="MESH", help="mesh of a part")
    parser.add_argument("-o", "--output", metavar="OUT.ply", required=True, help="file to write")
    parser.add_argument(
        "--radius",
        metavar="LENGTH",
        help="of the balls over which curvature is averaged, in the mesh's unit or a share of the diagonal such as 2%% "
        "(default: 1.5 median edges)",
    )
    parser.add_argument(
        "--least-turn",
        metavar="DEGREES",
        type=float,
        default=10.0,
        help="by how much neighbouring faces differ at least in how they bend (default: 10)",
    )
    parser.add_argument("--picture", metavar="FILE.png", help="draw the faces from four sides")
    options.add_target_options(parser)
    parser.add_argument("--threads", metavar="N", type=int, help="threads to use (default: one a core)")
    options.add_quiet(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Segment, write, draw."""
    from subdfit import api

    if Path(args.output).suffix.lower() != ".ply":
        raise InputError(f"{args.output}: labels of faces are kept in PLY files; give a name that ends in .ply")
    check_outputs([args.output], [args.mesh], pictures=[args.picture])
    names = ("radius", "least_turn", "creases", "repair", "keep_components", "fill_holes", "threads")
    found = api.segment(args.mesh, **{name: getattr(args, name) for name in names})
    console.stage("writing")
    api.write(args.output, found.to_data())
    if args.picture:
        console.stage("drawing")
        found.picture(args.picture, title=Path(args.mesh).name)
    console.rest()
    say(f"{counted(found.count, 'face')}, {counted(len(found.feature_edges), 'feature edge')}")
    return 0

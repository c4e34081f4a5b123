"""``subdfit convert``: a control mesh from one format to another."""

import argparse
from pathlib import Path
from typing import Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import DRAWN, check_level, check_outputs, write_surface
from subdfit.wording import counted


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "convert",
        help="control mesh from one format to another",
        description="Write a control mesh in other formats, with its scheme, creases and corners; a warning names what "
        "a format cannot hold.",
        allow_abbrev=False,
    )
    parser.add_argument("cage", metavar="CAGE", help="control mesh")
    parser.add_argument(
        "-o", "--output", metavar="OUT", action="append", required=True, help="file to write, may be repeated"
    )
    options.add_scheme(parser)
    parser.add_argument(
        "--tessellate",
        metavar="LEVEL",
        type=int,
        help="write the limit surface, every cell cut into 4^LEVEL parts, whatever the format",
    )
    options.add_quiet(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Read, check, and write in each format."""
    from subdfit import api

    check_level(args.tessellate)
    check_outputs(args.output, [args.cage])
    console.stage("converting")
    mesh = api.convert(args.cage, args.scheme)
    for path in args.output:
        if args.tessellate is not None or Path(path).suffix.lower() in DRAWN:
            write_surface(path, mesh, api.LimitSurface(mesh), args.tessellate)
        else:
            api.write(path, mesh)
    console.rest()
    t = mesh.topology
    tags = f"{counted(len(t.crease_edges), 'crease')}, {counted((t.corner_sharpness > 0).sum(), 'corner')}"
    say(f"{mesh.scheme}: {counted(t.vertex_count, 'vertex')}, {counted(t.face_count, 'face')}, {tags}")
    return 0

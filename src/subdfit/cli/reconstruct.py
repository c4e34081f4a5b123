"""``subdfit reconstruct``: from unorganised points to a triangle mesh."""

import argparse
from typing import Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import check_outputs, write_json
from subdfit.wording import counted

METHODS = ("greedy", "cgal", "poisson")
"""Repeats `subdfit.api.reconstructing.METHODS`, which imports compiled kernels; a test holds the two equal."""


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "reconstruct",
        help="join points to a triangle mesh",
        description="Join unorganised points to a triangle mesh through them, with the holes that the points leave. "
        "Normals in the file decide which side is outside; without them closed surfaces are turned outward.",
        allow_abbrev=False,
    )
    parser.add_argument("points", metavar="POINTS", help="points (.ply, .xyz); faces are not looked at")
    parser.add_argument(
        "-o", "--output", metavar="MESH", action="append", required=True, help="file to write, may be repeated"
    )
    parser.add_argument(
        "--method",
        choices=METHODS,
        default="greedy",
        help="greedy passes through the points (default); cgal is the same by the CGAL library, an extra; poisson "
        "passes near noisy points, by Open3D, an extra",
    )
    parser.add_argument(
        "--gap",
        metavar="SPACINGS",
        type=float,
        help="voids wider than so many times the distance between neighbouring points are holes (default: 2)",
    )
    parser.add_argument(
        "--small-hole", metavar="EDGES", type=int, help="close holes of at most so many edges (default: 8)"
    )
    parser.add_argument("--keep-components", metavar="N", type=int, help="keep the N largest components")
    group = parser.add_argument_group("simplification", "the topology stays")
    group.add_argument("--vertices", metavar="N", type=int, help="simplify to so many vertices")
    group.add_argument(
        "--max-error",
        metavar="LENGTH",
        help="simplify to the fewest vertices, no fewer than N, within a length of the points, in their unit, or a "
        "share of the diagonal such as 0.01%%",
    )
    group.add_argument(
        "--keep-data-points", action="store_true", help="simplify to some of the points, not to points of least error"
    )
    parser.add_argument("--json", metavar="FILE", help="write counts, rows left out and seconds")
    parser.add_argument("--picture", metavar="FILE.png", help="the points, and the mesh through them")
    options.add_machine_options(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Join, write, say what was done."""
    from subdfit import api

    check_outputs(args.output, [args.points], documents=[args.json], pictures=[args.picture])
    names = ("method", "keep_components", "vertices", "max_error", "keep_data_points", "threads", "memory")
    given = {name: getattr(args, name) for name in names}
    given |= {name: getattr(args, name) for name in ("gap", "small_hole") if getattr(args, name) is not None}
    found = api.reconstruct(args.points, **given)
    for path in args.output:
        api.write(path, found.mesh)
    if args.picture:
        api.picture(args.picture, found)
    if args.json:
        write_json(args.json, found.to_dict())
    console.rest()
    within = f"points within {found.error:.4g}, " if found.error else ""
    say(
        f"{counted(len(found.mesh.points), 'vertex')}, {counted(found.mesh.face_count, 'triangle')}, "
        f"{counted(len(found.left_out), 'point')} left out, {within}{found.seconds['total']:.1f} s"
    )
    return 0

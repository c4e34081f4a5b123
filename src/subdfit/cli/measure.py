"""``subdfit measure``: two-sided errors of any control mesh against any target."""

import argparse
from typing import Any

from subdfit.cli import options
from subdfit.cli.console import Console, say
from subdfit.cli.outputs import check_outputs, write_json
from subdfit.cli.summary import measure_table


def add_parser(commands: Any) -> None:
    """Add the command to the parser's commands."""
    parser = commands.add_parser(
        "measure",
        help="two-sided errors of a control mesh against a target",
        description="Measure the limit surface of a control mesh against a dense mesh or points, on both sides.",
        allow_abbrev=False,
    )
    parser.add_argument("cage", metavar="CAGE", help="control mesh")
    parser.add_argument("target", metavar="TARGET", help="dense mesh or points")
    options.add_scheme(parser)
    options.add_tolerances(parser, "judged only where given")
    options.add_target_options(parser)
    parser.add_argument("--json", metavar="FILE", help="write errors, counts and seconds")
    options.add_machine_options(parser)
    parser.set_defaults(run=run)


def run(args: argparse.Namespace, console: Console) -> int:
    """Measure, print the table, write the document."""
    from subdfit import api

    check_outputs([], [args.cage, args.target], documents=[args.json])
    found = api.compare(args.cage, args.target, scheme=args.scheme, **options.target_arguments(args))
    if args.json:
        write_json(args.json, found.to_dict())
    console.rest()
    say(measure_table(found))
    return 1 if found.status == "best_effort" else 0

"""Options that several commands share, and the names they may take.

The names are repeated here because the registries they come from import compiled kernels; a test holds them equal.
"""

import argparse
from typing import Any

SCHEMES = ("loop", "catmull-clark", "doo-sabin", "doo-sabin-averaging", "quad-triangle")
METHODS = ("auto", "tangent", "geometric", "lavoue")
INTERPOLATION_METHODS = ("cg", "chebyshev", "over-relaxation", "progressive")


def add_tolerances(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the three tolerances, as text that the library reads."""
    group = parser.add_argument_group(
        "tolerances",
        f"lengths in the target's unit, or shares of its diagonal such as 0.05%; all must hold; {default}",
    )
    for name, what in (("max", "largest"), ("rms", "root mean square"), ("mean", "mean")):
        group.add_argument(f"--{name}-error", metavar="LENGTH", help=f"{what} distance of the data from the surface")


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Add how a target is made ready."""
    group = parser.add_argument_group("the target")
    add_creases(group)
    group.add_argument(
        "--repair", action="store_true", help="cut apart edges of three faces and more, and one-sided surfaces"
    )
    group.add_argument("--keep-components", metavar="N", type=int, help="keep the N largest components")
    group.add_argument("--fill-holes", metavar="EDGES", type=int, help="close holes of at most so many edges")
    group.add_argument("--unit", metavar="NAME", help="name of the target's unit, for messages")


def add_creases(parser: Any) -> None:
    """Add ``--creases`` to a parser or a group."""
    parser.add_argument(
        "--creases",
        metavar="auto|none|ANGLE",
        default="auto",
        help="edges that stay sharp: those the file tags, else the surely sharp ones (auto, the default); none; or "
        "those that bend more than an angle in degrees",
    )


def add_machine_options(parser: argparse.ArgumentParser) -> None:
    """Add what concerns the machine and the messages."""
    group = parser.add_argument_group("the machine")
    group.add_argument("--threads", metavar="N", type=int, help="threads to use (default: one a core)")
    group.add_argument(
        "--memory",
        metavar="BYTES",
        help="refuse at once what would need more, such as 1500M or 2G, with an estimate; a fit takes no more control "
        "vertices than it allows",
    )
    add_quiet(group)


def add_quiet(parser: Any) -> None:
    """Add ``--quiet`` to a parser or a group."""
    parser.add_argument("--quiet", action="store_true", help="no progress; warnings and errors only")


def add_scheme(parser: argparse.ArgumentParser) -> None:
    """Add the scheme of a control mesh that is read."""
    parser.add_argument(
        "--scheme",
        choices=SCHEMES,
        help="overrides what the file says (default: the file's, else loop if all faces are triangles, else "
        "catmull-clark)",
    )


def target_arguments(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments of the library for the options above."""
    names = ("creases", "repair", "keep_components", "fill_holes", "unit", "threads", "memory")
    errors = ("max_error", "rms_error", "mean_error")
    return {name: getattr(args, name) for name in (*names, *errors)}

"""The program ``subdfit``: its commands, its exit codes, and what it says when something fails.

Nothing heavy is imported until a command runs, so that ``subdfit --help`` answers at once.
"""

import argparse
from collections.abc import Sequence
from typing import NoReturn

from subdfit import __version__
from subdfit.cli import convert, demo, fit, interpolate, measure, reconstruct, segment, subdivide
from subdfit.cli.console import Console, one_line
from subdfit.cli.faults import keep_details
from subdfit.errors import InputError, MachineError

DONE, NOT_REACHED, BAD_INPUT, FAILED, INTERRUPTED = 0, 1, 2, 3, 130
"""Exit codes: within tolerance; best effort; bad input or call; the machine's or our own fault; Ctrl-C."""


class _Parser(argparse.ArgumentParser):
    """Says in one line what is wrong with a call."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"subdfit: error: {one_line(message)}; see {self.prog} --help\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    argv
        Arguments without the program's name; None takes the process's own.
    """
    try:
        args = parser().parse_args(argv)
    except SystemExit as leaving:
        return int(leaving.code or 0)
    with Console(quiet=args.quiet) as console:
        try:
            code: int = args.run(args, console)
            return code
        except KeyboardInterrupt:
            console.error("interrupted before there was anything to write")
            return INTERRUPTED
        except InputError as error:
            console.error(one_line(error))
            return BAD_INPUT
        except Exception as error:
            console.error(f"{_what_failed(error)}; {keep_details(error)}")
            return FAILED


def parser() -> argparse.ArgumentParser:
    """Build the parser of all commands."""
    program = _Parser(
        prog="subdfit",
        description="Fit subdivision surfaces to dense meshes: few control points, a smooth surface, a certified "
        "error.",
        epilog="Exit codes: 0 within tolerance, 1 tolerance not reached, 2 bad input or call, 3 failure, 130 Ctrl-C.",
        allow_abbrev=False,
    )
    program.add_argument("--version", action="version", version=f"subdfit {__version__}")
    commands = program.add_subparsers(metavar="COMMAND", required=True, dest="command")
    for command in (fit, interpolate, reconstruct, segment, measure, subdivide, convert, demo):
        command.add_parser(commands)
    return program


def _what_failed(error: Exception) -> str:
    if isinstance(error, MachineError):
        return one_line(error)
    if isinstance(error, MemoryError):
        return "out of memory; give a coarser mesh, or a machine with more"
    if isinstance(error, OSError):
        return f"the machine failed: {one_line(error)}"
    return f"a fault of subdfit itself ({type(error).__name__}: {one_line(error)})"

"""The command line: composes what the rooms below offer, and computes nothing."""

from subdfit.cli.program import main

__all__ = ["main"]

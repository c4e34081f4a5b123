"""``python -m subdfit``: the command line, where the script is not on the path."""

from subdfit.cli import main

raise SystemExit(main())

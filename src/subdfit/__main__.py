"""``python -m subdfit``: the command line, where the script is not on the path."""

try:
    from subdfit.cli import main

    code = main()
except KeyboardInterrupt:
    code = 130
raise SystemExit(code)

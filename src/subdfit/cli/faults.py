"""What is kept of a failure: the traceback, in a file of its own."""

import os
import tempfile
import traceback
from pathlib import Path


def keep_details(error: BaseException) -> str:
    """Write an exception's traceback to the folder for temporary files, and say where."""
    try:
        handle, name = tempfile.mkstemp(prefix="subdfit-", suffix=".log")
        os.close(handle)
        Path(name).write_text("".join(traceback.format_exception(error)), encoding="utf-8")
    except (OSError, MemoryError):
        return "its details could not be kept"
    return f"details in {name}"

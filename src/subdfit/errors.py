"""The exception tree: everything that subdfit raises on purpose."""


class SubdfitError(Exception):
    """Base of all errors that subdfit raises on purpose; its text is one line for the user."""


class InputError(SubdfitError, ValueError):
    """The caller's file, mesh or option cannot be used; the text says what, where, and how to mend it."""


class MachineError(SubdfitError, RuntimeError):
    """The machine failed us: a file that cannot be written, memory that does not suffice."""

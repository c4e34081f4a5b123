"""Files of meshes: `read` and `write` by extension, each format in a file of its own."""

from subdfit.io.registry import check_writable, read, write

__all__ = ["check_writable", "read", "write"]

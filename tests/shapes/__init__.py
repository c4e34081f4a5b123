"""Tiny hard control meshes, and what tests need to walk over them."""

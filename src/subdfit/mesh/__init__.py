"""Meshes: connectivity, control meshes, the editor, and what mends a mesh from a file."""

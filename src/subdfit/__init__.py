"""subdfit: subdivision surfaces fitted to dense meshes, with a certified error."""

__version__ = "0.1.0"

"""subdfit: subdivision surfaces fitted to dense meshes, with a certified error."""

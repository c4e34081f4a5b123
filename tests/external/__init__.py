"""What other programs make of the same control meshes."""

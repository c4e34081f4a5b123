"""What is known of the data: searches, normals, features, faceting, samples."""

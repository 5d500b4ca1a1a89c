"""Methods of the sources, on numbers and arrays. The folder uses only the gravity constant of the systems."""

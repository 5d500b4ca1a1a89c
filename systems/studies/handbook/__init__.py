"""The sources' methods, on numbers and arrays; of the systems it needs gravity alone."""

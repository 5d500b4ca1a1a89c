"""One study over many cases, on many workers."""

"""Any system in compiled code: kernels of kinds of components, joined by tables."""

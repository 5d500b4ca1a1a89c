"""Code that tests share: systems, oracles and FMUs, imported as `support`."""

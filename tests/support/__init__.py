"""What tests share: systems, oracles and FMUs, imported as `support`."""

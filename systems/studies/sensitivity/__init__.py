"""Exact derivatives of equilibria and runs."""

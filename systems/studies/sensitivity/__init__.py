"""Exact derivatives of equilibria, load paths and runs."""

"""Fit to what was measured."""

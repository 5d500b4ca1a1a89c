"""Uncertain inputs: their distributions, and how sure a result is."""

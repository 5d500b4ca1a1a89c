"""Systems: from declarations to equilibria, simulations and studies."""

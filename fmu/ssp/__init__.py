"""System structures (SSP): systems of FMUs with their connections and parameters, as other tools exchange them."""

"""Floor 2: declarations, and the flat model that is assembled from them."""

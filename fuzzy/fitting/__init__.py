"""Systems from data: clusters, grids, consequents by least squares, searches."""

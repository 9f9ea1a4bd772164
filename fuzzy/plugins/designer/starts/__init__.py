"""What a new rule base can begin with: grids, clusters, control tables, shipped rule bases, and what packages add."""

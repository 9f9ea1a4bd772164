"""Leader and followers."""

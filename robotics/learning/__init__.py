"""Formation data, and the systems learnt from them."""

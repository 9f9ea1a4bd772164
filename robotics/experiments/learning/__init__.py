"""Formation data, and what is learnt from them."""

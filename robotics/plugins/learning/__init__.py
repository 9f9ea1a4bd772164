"""Formation data, and the networks that are learnt from them."""

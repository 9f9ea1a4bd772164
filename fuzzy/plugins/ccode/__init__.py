"""A system as C: one header and one source, in double, float or fixed point, proven equal to the inference here."""

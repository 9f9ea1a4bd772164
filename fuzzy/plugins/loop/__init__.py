"""The closed loop of a Sugeno system with one's own plant."""

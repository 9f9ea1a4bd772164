"""A Sugeno system compiled for speed."""

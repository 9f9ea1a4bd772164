"""The designer's panels about robots."""

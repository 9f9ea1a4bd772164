"""How robots avoid each other and obstacles."""

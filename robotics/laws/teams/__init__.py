"""How robots arrive together."""

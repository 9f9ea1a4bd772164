"""Coordination: laws by which robots on paths of their own arrive together, each knowing only what it hears."""

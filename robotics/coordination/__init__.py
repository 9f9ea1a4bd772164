"""Coordination: laws by which robots on paths of their own arrive together, each knowing only what it hears."""

# The catalogue of controllers names these laws, and these laws use the trackers beside it: whichever of the two
# packages is imported first, the catalogue comes before the laws.
import robotics.controllers  # noqa: F401

"""Pictures of a system."""

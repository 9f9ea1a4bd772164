"""Pictures of how robots avoid each other and obstacles: distances, meetings, modes, what sensors read."""

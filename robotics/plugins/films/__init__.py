"""Runs as films: .mp4 and .gif files, and the player as a widget for notebooks."""

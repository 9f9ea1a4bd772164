"""Obstacles and walls, random fields of them, and exact contacts."""

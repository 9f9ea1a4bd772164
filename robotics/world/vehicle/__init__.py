"""The robot: its parameters, its inverse dynamics, and the plant that moves it."""

"""The radio of a team: its graph, delays, losses and faults."""

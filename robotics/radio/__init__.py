"""The radio of a team: its graph, what is late or lost, and faults."""

"""The arena of tasks: teams that cooperate, meet, and go round obstacles, under faults; laws compared fairly."""

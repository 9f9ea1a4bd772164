"""What the simulator does without: a folder each."""

"""Moving pictures of a run: frames, animations and the player in a browser."""

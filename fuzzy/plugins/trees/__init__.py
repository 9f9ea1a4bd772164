"""Trees of Sugeno systems, in which some take what others answer: how they answer, learn, and are kept and drawn."""

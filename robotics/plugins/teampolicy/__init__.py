"""A learnt policy for teams among obstacles: a law, and how it is learnt."""

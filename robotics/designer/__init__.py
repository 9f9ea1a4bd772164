"""What the designer shows of robots."""

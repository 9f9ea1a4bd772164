"""What the designer shows of learning."""

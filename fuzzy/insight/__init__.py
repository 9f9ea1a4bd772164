"""What a system does, why, and what is odd about it: surfaces, explanations and diagnoses."""

"""What a system does and what is odd about it: explanations, diagnoses, surfaces."""

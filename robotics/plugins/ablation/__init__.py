"""Ablation: what a law's rules and rule bases are worth, by driving without them."""

"""Control laws: what each is, what it may know, and what it commands."""

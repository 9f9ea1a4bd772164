"""A system tuned on a table of data: the command ``fuzzy tune`` and the function behind it."""

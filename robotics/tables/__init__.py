"""TOML tables: their text, the lines of their keys, and the frozen dataclasses that are made of them."""

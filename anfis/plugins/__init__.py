"""What learning can do without, a folder each, found by entry points alone."""

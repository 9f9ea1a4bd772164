"""The report of a comparison: chapters, claims, pages."""

"""The plug-ins of fuzzy: a folder each, found by entry points alone; nothing outside this folder imports them."""

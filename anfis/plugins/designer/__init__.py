"""The panel "Train" of the designer: learning from a table, in another process."""

"""Methods of learning: one module a method, the table of them, and the options that they read."""

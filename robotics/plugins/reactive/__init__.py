"""The field's reactive laws as baselines: stop and wait, potential field, dynamic window, ORCA."""

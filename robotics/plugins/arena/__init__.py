"""The arena: laws tuned with equal budgets, and compared on runs that no tuning has seen."""

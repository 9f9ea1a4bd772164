"""Laws that simulate their robot ahead and command the best of its futures."""

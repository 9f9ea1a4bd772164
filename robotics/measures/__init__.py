"""Metrics: functions from a run to numbers."""

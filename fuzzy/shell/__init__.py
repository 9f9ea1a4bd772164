"""Shared parts of the command lines: exit codes, messages, the progress bar."""

"""What every command line shares: exit codes, messages, the progress bar."""

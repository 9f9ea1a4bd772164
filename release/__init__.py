"""What is done for a release, beside the building of wheels."""

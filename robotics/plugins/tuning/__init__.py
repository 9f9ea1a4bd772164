"""The command ``robotics tune``, and before held against after on runs that tuning has not seen."""

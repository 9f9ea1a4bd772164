"""Logs: runs as MCAP files and rosbag2 folders, and the drives of any robot read back from such."""

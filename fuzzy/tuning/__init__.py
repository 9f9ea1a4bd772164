"""Tuning: what may move, the engines that move it, and the search towards a cost."""

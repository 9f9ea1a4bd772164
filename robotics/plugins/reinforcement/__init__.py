"""Environments for reinforcement learning: runs of the simulator as episodes, and policies trained on them.

Who imports it, before Gymnasium or after, can make the environments by their ids:
``gymnasium.make("fuzzyfleet/Tracking-v0")``.
"""

from robotics.plugins.reinforcement.registration import register

register()

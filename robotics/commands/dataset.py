"""The command line ``robotics dataset``: its commands."""

from fuzzy.shell.terminal import application
from robotics.commands.dataset_formation import formation
from robotics.commands.dataset_from_bag import from_bag
from robotics.commands.dataset_regenerate import regenerate

dataset = application("Make training data.", "robotics dataset formation -o formation.csv")
dataset.command()(formation)
dataset.command()(from_bag)
dataset.command()(regenerate)

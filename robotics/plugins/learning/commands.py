"""The command lines ``robotics dataset`` and ``robotics learn``: their commands."""

from fuzzy.shell.terminal import application

learn = application(
    "Learn rule bases: of formations from data, or from what another law does.",
    "robotics learn rules --from lyapunov --scenario lyapunov-sine --rules 8 --rounds 1 --seeds 4 -o learnt.fis",
    modules="robotics.plugins.learning.commands_learn_",
    commands="formation rules",
)
dataset = application(
    "Make training data.",
    "robotics dataset formation --kind well-posed -o formation.csv",
    program="robotics-dataset",
    modules="robotics.plugins.learning.commands_dataset_",
    commands="formation",
)

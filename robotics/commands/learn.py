"""The command line ``robotics learn``: its commands."""

from fuzzy.shell.terminal import application

learn = application(
    "Learn rule bases: of formations from data, or from what another law does.",
    "robotics learn rules --from lyapunov --scenario lyapunov-sine --rules 8 --rounds 1 --seeds 4 -o learnt.fis",
    modules="robotics.commands.learn_",
    commands="formation rules",
)

"""Runs made by hand, of standard robots with standard sonars."""

from robotics.simulation.channels import RECORDS
from robotics.simulation.run import About, Recorded, Run
from robotics.world.sensing.sonar import SONAR
from tests.robotics.world.vehicle.etsro import ETSRO


def handmade(seeds, time, samples, reference, paths, stopped, *, scenario="s", controller="c", **arrays):
    """A run with these arrays; one with ``team`` is that of a team."""
    robots = stopped.shape[1]
    kind = "team" if "team" in arrays else "tracking"
    about = About(scenario, kind, controller, "velocity", (ETSRO,) * robots, (SONAR,) * robots)
    recorded = {name: Recorded(values, RECORDS[name].axes) for name, values in {"samples": samples, **arrays}.items()}
    return Run(about, tuple(seeds), time, recorded, reference, tuple(paths), stopped)

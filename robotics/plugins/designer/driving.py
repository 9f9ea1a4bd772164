"""Which rule bases drive a robot, by the names of their variables."""

from fuzzy.system import Sugeno

_CURVES = {"eta", "theta", "lambda"}  # what rule bases of one input give that laws hold, as η of (6.4)


def drives(system: Sugeno) -> bool:
    """Whether all inputs of a system are known to a robot, and all its outputs to a law."""
    from robotics.laws.formation.leader_follower import FORMATION_INPUTS, FORMATION_OUTPUTS
    from robotics.laws.law import ControllerError
    from robotics.laws.rules.fuzzy_team import TEAM_OUTPUTS
    from robotics.laws.rules.own_rules import RULE_OUTPUTS
    from robotics.laws.rules.quantities import quantity_of

    inputs, outputs = ({v.name for v in variables} for variables in (system.inputs, system.outputs))
    if outputs <= {*FORMATION_OUTPUTS}:
        return inputs <= {*FORMATION_INPUTS}
    if outputs <= _CURVES:
        return len(inputs) == 1
    try:
        for name in inputs:
            quantity_of(name, system.name)
    except ControllerError:
        return False
    return outputs <= {*RULE_OUTPUTS, *(name for task in TEAM_OUTPUTS.values() for name in task)}

"""The ids by which Gymnasium makes the environments."""

TRACKING = "fuzzyfleet/Tracking-v0"


def register() -> None:
    """Register :data:`TRACKING`, for ``gymnasium.make`` and ``gymnasium.make_vec``, where Gymnasium is installed."""
    try:
        from gymnasium.envs.registration import register as add
        from gymnasium.envs.registration import registry
    except ModuleNotFoundError:
        return
    if TRACKING in registry:
        return
    here = "robotics.plugins.reinforcement"
    add(TRACKING, entry_point=f"{here}.single:TrackingEnv", vector_entry_point=f"{here}.vector:TrackingVectorEnv")

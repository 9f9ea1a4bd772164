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
    add(
        TRACKING,
        entry_point="robotics.plugins.reinforcement.single:TrackingEnv",
        vector_entry_point="robotics.plugins.reinforcement.vector:TrackingVectorEnv",
    )

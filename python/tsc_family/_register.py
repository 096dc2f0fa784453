"""Tells gymnasium of the environment. Gymnasium calls this while it is being imported, so that it imports little."""

ENV_ID = "tsc_family/Signal-v0"


def register() -> None:
    """Adds the environment to gymnasium's registry, once."""
    from gymnasium.envs.registration import register as add
    from gymnasium.envs.registration import registry

    if ENV_ID not in registry:
        add(id=ENV_ID, entry_point="tsc_family.envs:SignalEnv")

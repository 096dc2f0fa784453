"""Tells gymnasium of the environment."""

import sys
from pathlib import Path

ENV_ID = "tsc_family/Signal-v0"


def register() -> None:
    """Adds the environment to gymnasium's registry, once; raises ImportError where there is no gymnasium."""
    from gymnasium.envs.registration import register as add
    from gymnasium.envs.registration import registry

    if ENV_ID not in registry:
        add(id=ENV_ID, entry_point="tsc_family.envs:SignalEnv")


def is_command() -> bool:
    """Whether this process is the command ``tsc-family``."""
    started = list(getattr(sys, "orig_argv", sys.argv))
    as_module = any(pair == ("-m", "tsc_family") for pair in zip(started, started[1:]))
    return as_module or any(Path(word).name == "tsc-family" for word in started[:2])

"""Builds with maturin, against the SUMO that pip has installed for the build."""

import importlib.metadata
import os

from maturin import *  # noqa: F403  What a build backend is made of is maturin's.

# libsumo-sys looks here for headers and library.
os.environ["SUMO_HOME"] = str(importlib.metadata.distribution("eclipse-sumo").locate_file("sumo"))

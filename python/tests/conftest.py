"""What the tests share: a folder of networks that are built once, and a run in a folder of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tsc_family import _sumo

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def networks(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The networks of ``smoke`` for the lengths of episodes that the tests have."""
    folder = str(tmp_path_factory.mktemp("networks"))
    for seconds in (60, 120, 300):
        build = ["build-networks", "smoke", "--out", folder, "--set", f"demand.horizon_s={seconds}", "--quiet"]
        subprocess.run([sys.executable, "-m", "tsc_family", *build], check=True, stdin=subprocess.DEVNULL)
    return folder


@pytest.fixture(scope="session")
def grid(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A SUMO configuration of four signals with two lanes on each arm, its network from SUMO's own generator."""
    folder, (sumo, missing) = tmp_path_factory.mktemp("grid"), _sumo.home()
    assert sumo is not None, missing
    streets = ["--grid", "--grid.number", "2", "--grid.attach-length", "150", "--grid.length", "150", "-L", "2"]
    network = [*streets, "--tls.set", "A0,A1,B0,B1", "-o", str(folder / "grid.net.xml")]
    subprocess.run([str(sumo / "bin" / "netgenerate"), *network], check=True, capture_output=True)
    flows = "".join(
        f'<flow id="{number}" begin="0" end="120" period="4" from="{begin}" to="{end}"/>'
        for number, (begin, end) in enumerate([("left0A0", "B0right0"), ("bottom0A0", "A1top0"), ("top1B1", "B0bottom1")])
    )
    (folder / "grid.rou.xml").write_text(f"<routes>{flows}</routes>")
    (folder / "grid.sumocfg").write_text(
        '<configuration><input><net-file value="grid.net.xml"/><route-files value="grid.rou.xml"/></input>'
        '<time><begin value="0"/><end value="200"/></time></configuration>'
    )
    return folder / "grid.sumocfg"


@pytest.fixture
def tsc_family(networks: str, tmp_path: Path):
    """Runs the command in an empty folder; returns the finished process."""

    def run(*args: str, timeout: float = 120, **kwargs):
        return subprocess.run(
            [sys.executable, "-m", "tsc_family", *args],
            cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=timeout, **kwargs,
        )  # fmt: skip

    return run


@pytest.fixture
def evaluated(tsc_family, networks: str, tmp_path: Path):
    """Evaluates a class of a file on ``quiet`` for a minute; returns the records of it and the process."""

    def evaluate(text: str, name: str = "Mine", *options: str):
        (tmp_path / "mine.py").write_text("import numpy as np, tsc_family as tf\n" + text)
        done = tsc_family(
            "run", "smoke", "--controller", f"mine=mine.py:{name}", "--methods", "mine", "--out", "out",
            "--eval-seeds", "1", "--set", "demand.horizon_s=60", "--networks", networks, *options,
        )  # fmt: skip
        return records(tmp_path / "out"), done

    return evaluate


def records(folder: Path) -> list[dict]:
    """Returns the first lines of the records of ``mine``, in the order of the plan."""
    lines = [json.loads(path.read_text().splitlines()[0]) for path in sorted((folder / "done").rglob("*.jsonl"))]
    return [line for line in lines if line["method"] == "mine"]

"""The command as the package has it, and where it finds SUMO."""

import re
import sysconfig
from importlib import metadata
from pathlib import Path

import pytest

from tsc_family import _sumo
from tsc_family._command import error_of


def test_the_words_of_an_error_are_whole_also_where_they_contain_the_word():
    words = "warning: odd\nerror: --controller mine=a.py: Traceback\nRuntimeError: parse error: line 7\n"
    reason = "--controller mine=a.py: Traceback\nRuntimeError: parse error: line 7"
    assert str(error_of(words, 2)) == reason
    assert str(error_of("killed\n", 137)) == "killed"
    assert "exit code 137" in str(error_of("", 137))


def test_doctor_says_where_sumo_is(tsc_family):
    done = tsc_family("doctor")
    assert done.returncode == 0, done.stdout + done.stderr
    site = sysconfig.get_paths()["purelib"]
    assert re.search(rf"libsumo +{re.escape(site)}/sumo/lib64/libsumocpp.so", done.stdout), done.stdout
    assert re.search(rf"netconvert +{re.escape(site)}/sumo/bin/netconvert", done.stdout), done.stdout
    assert f"SUMO {_sumo.required()}" in done.stdout and "all is well" in done.stdout


@pytest.mark.parametrize("version", [None, "1.28.0"])
def test_another_sumo_and_none_are_said_with_the_way_out(monkeypatch, version):
    real = metadata.distribution

    def distribution(name):
        if name != "eclipse-sumo":
            return real(name)
        if version is None:
            raise metadata.PackageNotFoundError(name)
        return type("Package", (), {"version": version})

    monkeypatch.setattr(metadata, "distribution", distribution)
    folder, reason = _sumo.home()
    assert folder is None and "pip install 'tsc-family[sumo]'" in reason
    assert (version or "is not installed") in reason


def test_without_sumo_doctor_and_run_say_so_and_the_rest_works(tsc_family, tmp_path, networks):
    import subprocess
    import sys

    text = (
        "import sys\nfrom tsc_family import _sumo\n"
        "_sumo.home = lambda: (None, 'the package is not here; pip install it')\n"
        "from tsc_family.__main__ import main\nmain()\n"
    )
    (tmp_path / "without.py").write_text(text)

    def run(*args):
        return subprocess.run([sys.executable, "without.py", *args], cwd=tmp_path, capture_output=True, text=True,
                              env={"PATH": "/nowhere"})  # fmt: skip

    doctor = run("doctor")
    assert doctor.returncode == 4 and "SUMO cannot be used: the package is not here; pip install it" in doctor.stdout
    assert run("list", "smoke").returncode == 0
    # The network is there, so that nothing but SUMO is missing.
    assert tsc_family("build-networks", "smoke", "--out", networks).returncode == 0
    refused = run("signals", "busy", "smoke", "--networks", networks)
    assert refused.returncode == 4 and "pip install it" in refused.stderr + refused.stdout


def test_the_package_is_built_with_the_sumo_that_it_asks_for():
    pyproject = Path(__file__).parents[1] / "pyproject.toml"
    named = re.findall(r"eclipse-sumo==([\d.]+)", pyproject.read_text())
    assert len(named) == 2 and set(named) == {_sumo.required()}


def test_wrong_usage_is_exit_code_2(tsc_family):
    assert tsc_family("run", "--no-such").returncode == 2
    assert tsc_family("--version").stdout.startswith("tsc-family ")


def test_neither_gymnasium_nor_pandas_is_needed_to_evaluate(tmp_path):
    import subprocess
    import sys

    text = (
        "import sys\n"
        "for name in ('gymnasium', 'pettingzoo', 'pandas'): sys.modules[name] = None\n"
        "import tsc_family as tf\n"
        "class Mine(tf.Controller):\n"
        "    def train(self, env): env.reset()\n"
        "    def act(self, obs): return [0]\n"
        "result = tf.evaluate(Mine(), 'smoke', eval_seeds=1, settings={'demand.horizon_s': 60}, out='out', quiet=True)\n"
        "assert set(result.scores()['method']) == {'baseline', 'mine'}, result.scores()\n"
        "assert result.scores()['delay_s'].dtype == float\n"
    )
    (tmp_path / "plain.py").write_text(text)
    done = subprocess.run([sys.executable, "plain.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr

# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The package as a user gets it: built, installed, and looked at the way ROS 2 looks at it."""

from __future__ import annotations

import ast
import importlib
import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import pytest

import hijack_detect
from hijack_detect.nodes import NODES, entry_point

ROOT = Path(__file__).resolve().parents[1]
PROGRAMS = sorted([*NODES, "hijack-detect"])
LOCKS = ("requirements.txt", "requirements-test.txt")
LOCKED = re.compile(r"([a-z0-9-]+)==[^ ]+( ; [^;]+?)?( --hash=sha256:[0-9a-f]{64})+")

# Where the name to import is another than the name to install.
DISTRIBUTIONS = {
    "backports": "backports-zstd",
    "pydantic_core": "pydantic",
    "serial": "pyserial",
    "upath": "universal-pathlib",
    "yaml": "pyyaml",
}


@dataclass(frozen=True)
class Installed:
    """One installation: its prefix, and the environment in which a user works with it."""

    prefix: Path
    environment: dict[str, str]

    def run(self, program: str, *arguments: str, **variables: str) -> str:
        """Return the output of a program, started as `ros2 run` starts it."""
        path = self.prefix / "lib" / "hijack_detect" / program
        return run([path, *arguments], self.environment | variables)


def run(command: list[str | Path], environment: dict[str, str], folder: Path = ROOT) -> str:
    """Return what a command prints; a command that fails shows its output."""
    done = subprocess.run(
        command,
        env=environment,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}"
    return done.stdout


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a copy of what the package is made of, so that the checkout stays clean."""
    copy = tmp_path_factory.mktemp("source")
    for name in ("hijack_detect", "launch", "config", "bags", "resource"):
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("setup.py", "setup.cfg", "pyproject.toml", "package.xml", "LICENSE"):
        shutil.copy(ROOT / name, copy)
    return copy


@pytest.fixture(scope="module")
def wheel(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the wheel, built from the source archive as a release is."""
    pytest.importorskip("build")
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, source]
    run(command, dict(os.environ))
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def from_wheel(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Install the wheel into a virtual environment whose path has a space."""
    prefix = tmp_path_factory.mktemp("a place") / "venv"
    venv.create(prefix, symlinks=True)
    python = prefix / "bin" / "python"
    install = ["install", "--quiet", "--no-index", "--no-deps", wheel]
    run([sys.executable, "-m", "pip", "--python", python, *install], dict(os.environ))
    packages = next((prefix / "lib").glob("python3.*")) / "site-packages"
    # The libraries are borrowed; the second file answers which interpreter a program starts.
    (packages / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    answer = "os.write(1, sys.prefix.encode()), os._exit(0)"
    (packages / "which.pth").write_text(
        f"import os, sys; 'WHICH_ENVIRONMENT' in os.environ and ({answer})\n"
    )
    environment = dict(os.environ, AMENT_PREFIX_PATH=str(prefix))
    environment.pop("PYTHONPATH", None)
    return Installed(prefix, environment)


@pytest.fixture(scope="module")
def from_colcon(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Build with colcon and source the workspace's setup.bash."""
    scripts = Path(sysconfig.get_path("scripts"))
    colcon = shutil.which("colcon", path=f"{scripts}{os.pathsep}{os.environ['PATH']}")
    if colcon is None or " " in sys.executable:
        pytest.skip("colcon is missing, or its Python is in a path with a space, as it cannot be")
    workspace = tmp_path_factory.mktemp("workspace")
    run([colcon, "build", "--base-paths", source], dict(os.environ), workspace)
    clean = {k: v for k, v in os.environ.items() if k not in ("AMENT_PREFIX_PATH", "PYTHONPATH")}
    printed = run(["bash", "-c", ". install/setup.bash && env -0"], clean, workspace)
    environment = dict(line.split("=", 1) for line in printed.split("\0") if line)
    return Installed(workspace / "install" / "hijack_detect", environment)


@pytest.fixture(scope="module")
def metadata(from_wheel: Installed) -> importlib.metadata.Distribution:
    """Return what the installed wheel says of itself."""
    folder = next(from_wheel.prefix.glob("lib/python3.*/site-packages/hijack_detect-*.dist-info"))
    return importlib.metadata.Distribution.at(folder)


@pytest.fixture(params=["wheel", "colcon"])
def installed(request: pytest.FixtureRequest) -> Installed:
    """Return each installation in turn."""
    value = request.getfixturevalue(f"from_{request.param}")
    assert isinstance(value, Installed)
    return value


def test_ros2_run_finds_exactly_the_programs(installed: Installed) -> None:
    folder = installed.prefix / "lib" / "hijack_detect"
    found = [path.name for path in folder.rglob("*") if os.access(path, os.X_OK)]
    assert sorted(found) == PROGRAMS


def test_ament_index_knows_the_package(
    installed: Installed, monkeypatch: pytest.MonkeyPatch
) -> None:
    index = pytest.importorskip("ament_index_python")
    monkeypatch.setenv("AMENT_PREFIX_PATH", installed.environment["AMENT_PREFIX_PATH"])
    prefix = str(installed.prefix)
    assert index.get_packages_with_prefixes()["hijack_detect"] == prefix
    assert index.get_resource("packages", "hijack_detect") == ("", prefix)
    share = Path(index.get_package_share_directory("hijack_detect"))
    assert (share / "package.xml").read_bytes() == (ROOT / "package.xml").read_bytes()


def test_launch_config_and_bags_are_shared(installed: Installed) -> None:
    share = installed.prefix / "share" / "hijack_detect"
    for top in ("launch", "config", "bags"):
        expected = files_below(ROOT / top)
        assert files_below(share / top) == expected, top
        for name in expected:
            assert (share / top / name).read_bytes() == (ROOT / top / name).read_bytes()


def test_the_live_page_is_in_the_package(installed: Installed) -> None:
    wanted = files_below(ROOT / "hijack_detect/live/page")
    assert "index.html" in wanted
    (page,) = installed.prefix.glob("lib/python3.*/site-packages/hijack_detect/live/page")
    assert files_below(page) == wanted


@pytest.mark.parametrize("program", ["bag_replay", "drag_detector", "hijack-detect"])
def test_program_runs_from_lib(installed: Installed, program: str) -> None:
    assert "usage" in installed.run(program, "--help").lower()


def test_launchers_start_the_interpreter_of_their_environment(from_wheel: Installed) -> None:
    for program in PROGRAMS:
        assert from_wheel.run(program, WHICH_ENVIRONMENT="1") == str(from_wheel.prefix), program


@pytest.mark.parametrize("path", ["hijack_detect.cli.main:main", *map(entry_point, NODES)])
def test_every_program_has_its_function(path: str) -> None:
    pytest.importorskip("rclpy")
    module, _, function = path.partition(":")
    assert callable(getattr(importlib.import_module(module), function))


def test_versions_agree(metadata: importlib.metadata.Distribution) -> None:
    version = hijack_detect.__version__
    assert metadata.version == version
    assert ET.parse(ROOT / "package.xml").findtext("version") == version
    assert f"## [{version}]" in (ROOT / "CHANGELOG.md").read_text()


@pytest.mark.parametrize("name", LOCKS)
def test_locks_are_pinned_and_hashed(name: str) -> None:
    assert "://" not in (ROOT / name).read_text()
    for line in requirement_lines(name):
        assert LOCKED.fullmatch(line), line


def test_locks_hold_what_the_package_requires(metadata: importlib.metadata.Distribution) -> None:
    locked = {line.split("==")[0] for name in LOCKS for line in requirement_lines(name)}
    extras = ("test", "wheels", "analysis", "live")
    assert set().union(*(required(metadata, extra) for extra in extras)) <= locked


def test_locks_hold_what_the_locked_packages_require() -> None:
    """The set-up installs the locks as they are and resolves nothing."""
    if not any(Path(sys.prefix).glob("test-*")):
        pytest.skip("this environment was not made by make setup-test")
    run([sys.executable, "-m", "pip", "check"], dict(os.environ))


def test_imported_packages_are_declared(metadata: importlib.metadata.Distribution) -> None:
    declared = {element.text for element in ET.parse(ROOT / "package.xml").iter("exec_depend")}
    for extra in ("analysis", "corpora", "live", "logs", "mavlink"):
        declared |= required(metadata, extra)
    for name in sorted(imported()):
        assert DISTRIBUTIONS.get(name, name) in declared, f"{name} is imported and not declared"


def files_below(folder: Path) -> list[str]:
    """Return the relative paths of all files below a folder."""
    return sorted(
        str(path.relative_to(folder))
        for path in folder.rglob("*")
        if path.is_file() and path.parent.name != "__pycache__"
    )


def requirement_lines(name: str) -> list[str]:
    """Return one line a requirement of a lock file: lines joined, comments left out."""
    joined = re.sub(r" \\\n +", " ", (ROOT / name).read_text())
    return [line for line in joined.splitlines() if line and not line.lstrip().startswith("#")]


def normal(name: str) -> str:
    """Return a distribution's name in the form in which names are compared."""
    return re.sub(r"[-_.]+", "-", name).lower()


def required(metadata: importlib.metadata.Distribution, extra: str = "") -> set[str]:
    """Return the names that the package requires, with those of one extra."""
    names = set()
    for requirement in metadata.requires or []:
        name, _, conditions = requirement.partition(";")
        if "extra ==" not in conditions or f"extra == '{extra}'" in conditions.replace('"', "'"):
            names.add(normal(re.split(r"[^\w.-]", name)[0]))
    return names


def imported() -> set[str]:
    """Return the top-level names from elsewhere that the package's modules import."""
    # Python 3.14 has zstd in its standard library, as compression.zstd.
    ours = {*sys.stdlib_module_names, "hijack_detect", "compression"}
    names = set()
    for path in (ROOT / "hijack_detect").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.split(".")[0])
    return names - ours


def test_every_source_file_says_whose_it_is() -> None:
    folders = (
        "hijack_detect",
        "test",
        "benchmarks",
        "experiments",
        "stress",
        "tools",
        "examples",
        "launch",
    )
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    assert len(sources) > 400
    bare = [str(one) for one in sources if not one.read_text().startswith("# Copyright ")]
    assert bare == []

"""The shape of the house: what is shipped, who imports whom, how large a room may be."""

import ast
import os
import shutil
import subprocess
import sys
import zipfile
from importlib import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
GIVEN = ("MPICC", "HDF5_DIR", "MPIEXEC", "PYTHON")  # variables for `make setup`
MAY_IMPORT = {
    "kernel": {"numpy", "numba", "llvmlite", "kernel"},
    "sweep": {
        "numpy",
        "h5py",
        "scipy",
        "mpi4py",
        "pydantic",
        "pyarrow",
        "h5netcdf",
        "shtab",
        "tqdm",
        "kernel",
        "sweep",
    },
    "analysis": {
        *{"numpy", "pandas", "scipy", "matplotlib", "PIL", "pydantic", "jinja2", "markupsafe", "h5py", "xarray"},
        *{"kernel", "sweep", "analysis"},
    },
}


def imports(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield (node.module or "").partition(".")[0]


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_imports_point_one_way(package):
    allowed = MAY_IMPORT[package] | sys.stdlib_module_names
    for file in (ROOT / package).rglob("*.py"):
        assert set(imports(file)) <= allowed, file


ROOMS = ("plan", "store", "serve", "tell", "site")  # each may use those before it
SHARED = {"errors", "files", "log", "machine", "schema"}


@pytest.mark.parametrize("room", ROOMS)
def test_the_sweeps_rooms_build_on_each_other_one_way(room):
    allowed = SHARED | set(ROOMS[: ROOMS.index(room) + 1])
    for file in (ROOT / "sweep" / room).rglob("*.py"):
        nodes = [node for node in ast.walk(ast.parse(file.read_text())) if isinstance(node, ast.ImportFrom)]
        modules = [(node.module or "").split(".") for node in nodes]
        assert {module[1] for module in modules if module[0] == "sweep"} <= allowed, file


@pytest.mark.parametrize("package", (*MAY_IMPORT, "tests"))
def test_files_and_functions_stay_small(package):
    for file in (ROOT / package).rglob("*.py"):
        text = file.read_text()
        assert len(text.splitlines()) <= 350, file
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef):
                assert node.end_lineno - node.lineno < 80, (file, node.name)


DECIDING = (
    *("method", "certify", "condition", "estimate", "arrival", "pairs", "extrapolate", "integrate"),
    *("splitting/rules", "splitting/implicit", "splitting/explicit", "linear/__init__"),
)
FORMULAS = {"whole_substeps", "run_implicit"}  # whose numbers are algebra, or the length of an array
PLAIN = {-1, 0, 1, 2, 0.5}


@pytest.mark.parametrize("name", DECIDING)
def test_no_number_that_decides_a_step_or_a_run_is_without_a_name(name):
    tree = ast.parse((ROOT / "kernel" / f"{name}.py").read_text())
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name not in FORMULAS]
    numbers = [node for one in functions for node in ast.walk(one) if isinstance(node, ast.Constant)]
    bare = {(node.lineno, node.value) for node in numbers if type(node.value) in (int, float)}
    assert not {(line, value) for line, value in bare if value not in PLAIN}


def test_the_wheel_holds_exactly_the_three_packages(tmp_path):
    source = tmp_path / "source"
    for name in ("pyproject.toml", "README.md"):
        (source / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    for package in (*MAY_IMPORT, "jobs"):
        shutil.copytree(ROOT / package, source / package)
    build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", str(tmp_path), "."]
    subprocess.run(build, cwd=source, check=True, timeout=240)
    (wheel,) = tmp_path.glob("*.whl")
    top = {name.partition("/")[0] for name in zipfile.ZipFile(wheel).namelist()}
    assert {name for name in top if not name.endswith(".dist-info")} == set(MAY_IMPORT)


@pytest.mark.parametrize("script", sorted((ROOT / "jobs").rglob("*.sbatch")), ids=lambda path: path.name)
def test_slurm_scripts_are_correct_shell(script):
    subprocess.run(["bash", "-n", script], check=True, timeout=60)
    if checker := shutil.which("shellcheck"):
        subprocess.run([checker, script], check=True, timeout=60)


SCENES = set((ROOT / "jobs").rglob("scenes/*.toml"))


@pytest.mark.parametrize("spec", sorted(set((ROOT / "jobs").rglob("*.toml")) - SCENES), ids=lambda path: path.name)
def test_every_spec_in_jobs_is_valid(spec):
    from sweep.plan.spec import read_spec

    assert read_spec(spec)[0].tasks > 0


def test_every_pinned_package_can_be_had_by_the_python_of_debian_12():
    from packaging.requirements import Requirement
    from packaging.specifiers import SpecifierSet

    lines = (ROOT / ".ci" / "constraints.txt").read_text().splitlines()
    names = [Requirement(line).name for line in lines if line and not line.startswith("#")]
    found = {name: metadata.metadata(name)["Requires-Python"] for name in names if _installed(name)}
    assert len(found) > 50
    assert {name: rule for name, rule in found.items() if rule and "3.11.2" not in SpecifierSet(rule)} == {}


def _installed(name):
    """Whether it is, in the version that is pinned: the peers are not."""
    try:
        return bool(metadata.version(name))
    except metadata.PackageNotFoundError:
        return False


def test_make_hands_on_only_the_variables_that_were_given(tmp_path):
    (tmp_path / "show.mk").write_text("show:\n\t@env\n")
    known = {name: value for name, value in os.environ.items() if name not in GIVEN}

    def handed_on(**given: str) -> set[str]:
        make = ["make", "-s", "-f", "Makefile", "-f", str(tmp_path / "show.mk"), "show"]
        said = subprocess.run(make, cwd=ROOT, env=known | given, capture_output=True, text=True, check=True, timeout=60)
        return {line for line in said.stdout.splitlines() if line.partition("=")[0] in GIVEN}

    assert not [line for line in handed_on() if line.endswith("=")]
    assert "MPICC=/opt/mpicc" in handed_on(MPICC="/opt/mpicc")

"""Claims about the recipes for Apptainer and conda: they say what the project says, and their scripts are sound."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
APPTAINER = ROOT / "recipes" / "apptainer.def"
CONDA = ROOT / "recipes" / "conda" / "recipe.yaml"
OTHER_NAMES = {"matplotlib": "matplotlib-base"}  # what conda-forge calls it, without what draws on a screen


def section(name):
    """The lines of a section of the Apptainer recipe."""
    found = re.search(rf"^%{name}\n(.*?)(?=^%|\Z)", APPTAINER.read_text(), re.MULTILINE | re.DOTALL)
    return found[1]


def listed(key):
    """The items below a key of the conda recipe, as it is written."""
    lines = CONDA.read_text().partition(f"\n  {key}:\n")[2].splitlines()
    items = [line.strip() for line in lines]
    end = next((k for k, item in enumerate(items) if not item.startswith("- ")), len(items))
    return [item.removeprefix("- ") for item in items[:end]]


def test_the_conda_recipe_asks_for_what_the_project_asks_for():
    asked = dict(line.split(" ", 1) for line in listed("run") if " " in line)
    wanted = dict(re.fullmatch(r"([\w-]+)(>=[\d.]+)", one).groups() for one in PROJECT["dependencies"])
    wanted |= {"python": PROJECT["requires-python"]}
    assert {OTHER_NAMES.get(name, name): bound for name, bound in wanted.items()} == {
        name: bound.split()[0] for name, bound in asked.items()
    }
    assert [line for line in listed("run") if " " not in line] == PROJECT["optional-dependencies"]["mpi"]


def test_the_conda_recipe_has_the_projects_name_version_licence_and_commands():
    text = CONDA.read_text()
    for line in (f"name: {PROJECT['name']}", f"version: {PROJECT['version']}", f"license: {PROJECT['license']}"):
        assert f"  {line}\n" in text
    commands = [f"{name} = {place}" for name, place in PROJECT["scripts"].items()]
    assert [line for line in text.split("entry_points:")[1].splitlines() if " = " in line] == [
        f"      - {command}" for command in commands
    ]
    setuptools = re.search(r'"setuptools(>=\d+)"', (ROOT / "pyproject.toml").read_text())[1]
    assert f"- setuptools {setuptools}\n" in text


def test_the_apptainer_recipe_installs_every_debian_package_that_the_set_up_would_miss():
    said = (ROOT / ".ci" / "setup").read_text()
    needed = {"gcc", "mpich", "libhdf5-mpich-dev", "python3-venv", "python3-dev", "python3"}
    assert all(package.replace("mpich-dev", "$debian-dev") in said for package in needed)
    assert needed <= set(section("post").split())
    assert f"version {PROJECT['version']}\n" in section("labels")
    assert f"licenses {PROJECT['license']}\n" in section("labels")


@pytest.mark.parametrize("name", ["post", "environment", "runscript", "test"])
def test_every_script_of_the_apptainer_recipe_can_be_read_by_a_plain_shell(name):
    subprocess.run(["sh", "-n"], input=section(name), text=True, check=True, timeout=60)


@pytest.mark.skipif(shutil.which("shellcheck") is None, reason="shellcheck is not installed")
def test_shellcheck_finds_nothing_in_the_recipes_scripts():
    for name in ("post", "runscript", "test", "environment"):
        subprocess.run(["shellcheck", "-s", "sh", "-"], input=section(name), text=True, check=True, timeout=60)
    subprocess.run(["shellcheck", str(ROOT / "recipes" / "try-apptainer")], check=True, timeout=60)

"""Style and types of what is written in Python: ruff and mypy, as pyproject.toml says. Skipped where they are not installed
(python_checks/requirements-ci.txt)."""

import importlib.util
import subprocess
import sys

import pytest
from support import ROOT


def run_module(name, *arguments):
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed: python_checks/requirements-ci.txt has it")
    result = subprocess.run([sys.executable, "-m", name, *arguments], cwd=ROOT, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


def test_ruff_finds_nothing():
    run_module("ruff", "check", "--no-cache", "--output-format", "concise", ".")


def test_mypy_finds_nothing(tmp_path):
    run_module("mypy", "--cache-dir", str(tmp_path))

"""The stubs are those of the module as it is, and a type checker takes them."""

import importlib.util
import inspect
import subprocess
import sys

import pytest
from conftest import SOURCE

import knead


@pytest.fixture(scope="module")
def made():
    spec = importlib.util.spec_from_file_location("make_stubs", SOURCE / "bindings/python/tests/make_stubs.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.text()


def test_the_stubs_are_up_to_date(made):
    assert (SOURCE / "bindings/python/knead/__init__.pyi").read_text() == made


def test_the_stubs_name_everything(made):
    for name in knead.__all__:
        assert f"class {name}" in made or f"def {name}(" in made, name


def test_every_public_thing_has_a_docstring():
    for name in knead.__all__:
        thing = getattr(knead, name)
        if isinstance(thing, type) and issubclass(thing, Exception):
            continue
        assert inspect.getdoc(thing), name
        if not isinstance(thing, type) or issubclass(thing, knead.Stroke):
            continue
        for member, value in vars(thing).items():
            assert member.startswith("_") or member == "insert" or inspect.getdoc(value), f"{name}.{member}"


def test_a_type_checker_takes_the_stubs(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "use.py").write_text(
        "import knead\n"
        "shape = knead.read('a.ply')\n"
        "pull = knead.Implicit(path=[[0, 1, 0], [0, 1.4, 0]], inner=0.1, outer=0.5)\n"
        "moved = knead.deform(shape.vertices, [pull], until=1)\n"
        "session: knead.Session = knead.Session([pull])[:1]\n"
        "wrong: str = knead.Flow(session)(moved)\n"
    )
    done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path / "cache"), str(tmp_path / "use.py")],
                          capture_output=True, text=True)
    errors = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(errors) == 1 and 'use.py:6: error: Incompatible types' in errors[0], done.stdout + done.stderr

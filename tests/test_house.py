"""Guards of the house: what no single module can check about the repository."""

import ast
import importlib.metadata
import re
import subprocess
from pathlib import Path

import pytest

import rotorpong

HOUSE = Path(__file__).resolve().parents[1]
TESTS = sorted((HOUSE / "tests").rglob("*.py"))
SOURCES = sorted((HOUSE / "src").rglob("*.py"))
LONGEST_FUNCTION = 60  # lines
PIN = re.compile(r"[a-z0-9-]+==[0-9][0-9a-z.]*( ; [a-z_]+ .+)?")
PRIVATE = re.compile(
    r"fil[e]://|(?<![\w.])/(?:home|root|work|Users|opt)/\w|pypi\.or[g]|pythonhoste[d]"
    r"|--(?:extra-)?index-ur[l]|--find-link[s]"
)


def house_files():
    """Every file that is, or would be, under version control."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=HOUSE, capture_output=True, text=True, check=True).stdout
    return [path for name in listed.split("\0") if name and (path := HOUSE / name).is_file()]


def functions_with_their_parent(tree):
    for parent in ast.walk(tree):
        for child in ast.iter_child_nodes(parent):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
                yield child, parent


def sizes_of(source):
    """Lines of every function, by its name and the names of what it is in."""
    sizes = {}

    def visit(node, inside):
        for child in ast.iter_child_nodes(node):
            named = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
            name = ".".join((*inside, child.name)) if named else ""
            if named and not isinstance(child, ast.ClassDef):
                size = child.end_lineno - child.lineno + 1
                sizes[name] = max(size, sizes.get(name, 0))
            visit(child, (*inside, child.name) if named else inside)

    visit(ast.parse(source), ())
    return sizes


def uncollected_asserts(source):
    """Names of functions that assert something but that neither pytest nor a test ever calls."""
    lost = []
    for function, parent in functions_with_their_parent(ast.parse(source)):
        asserts = any(isinstance(node, ast.Assert) for node in ast.walk(function))
        in_class = isinstance(parent, ast.ClassDef) and parent.name.startswith("Test")
        is_test = function.name.startswith("test_") and (in_class or isinstance(parent, ast.Module))
        is_used = len(re.findall(rf"\b{function.name}\b", source)) > 1
        if asserts and not is_test and not is_used:
            lost.append(function.name)
    return lost


def imported_modules(source):
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


@pytest.mark.parametrize("file", TESTS, ids=lambda file: file.name)
def test_every_function_that_asserts_is_collected(file):
    assert uncollected_asserts(file.read_text()) == []


def test_the_search_for_lost_asserts_finds_them():
    assert uncollected_asserts("def tset_typo():\n    assert 1") == ["tset_typo"]
    assert uncollected_asserts("def test_a():\n    def test_b():\n        assert 1") == ["test_b"]
    assert uncollected_asserts("class Case:\n    def test_a(self):\n        assert 1") == ["test_a"]
    assert uncollected_asserts("class TestIt:\n    def test_a(self):\n        assert 1") == []
    assert uncollected_asserts("def check():\n    assert 1\ndef test_a():\n    check()") == []


def test_every_file_with_tests_is_one_that_pytest_opens():
    with_tests = [file for file in TESTS if re.search(r"^def test_", file.read_text(), re.M)]
    assert [file.name for file in with_tests if not file.name.startswith("test_")] == []


def test_no_two_test_files_share_a_name():
    names = [file.name for file in TESTS if file.name.startswith("test_")]
    assert len(names) == len(set(names))


def test_no_file_names_a_machine_or_a_package_index():
    found = []
    for file in house_files():
        text = file.read_bytes().decode("utf-8", errors="ignore")
        if file.name != "LICENSE":
            found += [f"{file.relative_to(HOUSE)}: {hit}" for hit in PRIVATE.findall(text)]
    assert found == []


def test_the_search_for_machine_paths_finds_them():
    assert PRIVATE.search("see " + "/home" + "/me/x")
    assert PRIVATE.search("file" + ":///x")
    assert not PRIVATE.search("frame/work/x ../root/x https://example.com/home/x")


def test_constraints_are_versions_and_markers_only():
    lines = (HOUSE / "constraints.txt").read_text().splitlines()
    assert [line for line in lines if not PIN.fullmatch(line)] == []


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(HOUSE / "src")))
def test_kernels_are_compiled_in_one_place_only(file):
    roots = {module.partition(".")[0] for module in imported_modules(file.read_text())}
    assert "numba" not in roots or file.name == "kernels.py"


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(HOUSE / "src")))
def test_a_source_file_says_what_it_is_and_its_functions_are_short(file):
    tree = ast.parse(file.read_text())
    assert ast.get_docstring(tree)
    sizes = sizes_of(file.read_text())
    long = {name: size for name, size in sizes.items() if size > LONGEST_FUNCTION}
    assert long == {}


def test_the_size_of_every_function_counts_also_where_names_are_equal():
    source = "class A:\n    def run(self):\n        1\n        2\nclass B:\n    def run(self): 3\n"
    source += "if 1:\n    def run():\n        4\nelse:\n    def run(): 5\n"
    assert sizes_of(source) == {"A.run": 3, "B.run": 1, "run": 2}


@pytest.mark.parametrize(
    "file", [f for f in SOURCES if f.name == "__init__.py"], ids=lambda file: file.parent.name
)
def test_a_package_offers_few_names(file):
    tree = ast.parse(file.read_text())
    names = [a for node in tree.body if isinstance(node, ast.ImportFrom) for a in node.names]
    assert len(names) <= 8


def test_an_old_python_can_read_the_script_that_tells_it_so():
    ast.parse((HOUSE / "dev").read_text(), feature_version=(3, 7))


def test_version_citation_and_changelog_agree():
    version = rotorpong.__version__
    assert importlib.metadata.version("rotorpong") == version
    assert f"version: {version}\n" in (HOUSE / "CITATION.cff").read_text()
    assert f"## [{version}]" in (HOUSE / "CHANGELOG.md").read_text()

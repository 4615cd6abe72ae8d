"""Turns the docstrings of the sources into what Sphinx reads, without touching the sources.

They are plain prose: words of code stand between single backticks, equations and pictures are
indented, and what a field or constant means stands in the comment behind it, once. So

- indented blocks become literal blocks, and signs that mean something to Sphinx are escaped;
- the comments behind the fields of a record become its list of fields, and those behind the
  constants of a module its list of constants.
"""

import ast
import inspect
import re
import sys
import textwrap
import tokenize
from collections.abc import Iterator
from dataclasses import is_dataclass
from io import StringIO
from itertools import pairwise
from typing import Any

SECTION = re.compile(r"(Args|Attributes|Raises|Returns|Yields):$")
QUOTED = re.compile(r"``.+?``|`.+?`", re.S)
NAME = re.compile(r"[A-Za-z_][\w.]*\w")
SPECIAL = re.compile(r"([*|\\])|(?<=\w)(_)(?!\w)")
NOTE = re.compile(r"^\.\. only:: html\n\n +\.\. note::\n.*?(?=^\.\. \w)", re.M | re.S)
ARCHIVE = re.compile(r"^ +\.\. container:: sphx-glr-download sphx-glr-download-zip\n\n.*\n", re.M)
LONGEST_VALUE = 60  # characters of a constant that is shown


def prepare(_app: Any, what: str, _name: str, thing: Any, *more: Any) -> None:
    """Rewrite the lines of one docstring in place; arguments of `autodoc-process-docstring`."""
    lines: list[str] = more[-1]
    first = lines[:1]
    lines[:] = readable("\n".join(lines)).splitlines()
    if what in ("class", "exception") and first == (inspect.getdoc(thing) or "").splitlines()[:1]:
        lines += fields_of(thing)
    if what == "module":
        lines += constants_of(thing)
    if what in ("data", "attribute"):  # or napoleon takes what stands before a colon for a type
        lines[:1] = [part.strip() for part in lines[0].replace(": ", ":\n", 1).splitlines()]
    lines.append("")


def is_left_out(_app: Any, _what: str, _name: str, thing: Any, *_more: Any) -> bool | None:
    """Leave out what Python itself says about the fields of a named tuple."""
    said = getattr(thing, "__doc__", None) or ""
    return True if said.startswith("Alias for field number") else None


def without_zip(_app: Any, page: str, source: list[str]) -> None:
    """Leave out of an example's page what leads to an archive of its one file."""
    if page.startswith("gallery/"):
        source[0] = ARCHIVE.sub("", NOTE.sub("", source[0]))


def readable(text: str) -> str:
    """Return a docstring with literal blocks marked and special signs escaped."""
    parts = [
        "::\n\n" + part if literal else escaped(part) for literal, part in blocks(text.splitlines())
    ]
    return "\n\n".join(parts)


def blocks(lines: list[str]) -> Iterator[tuple[bool, str]]:
    """Yield paragraphs, and whether each is indented without belonging to a section."""
    in_section = False
    paragraph: list[str] = []
    literal: list[str] = []
    for line in [*lines, ""]:
        if line.strip():
            paragraph.append(line)
            continue
        if not paragraph:
            continue
        indented = all(one.startswith("    ") for one in paragraph) and not in_section
        if indented:
            literal += ["", *paragraph] if literal else paragraph
        else:
            if literal:
                yield True, "\n".join(literal)
                literal = []
            in_section = bool(SECTION.match(paragraph[0]))
            yield False, "\n".join(paragraph)
        paragraph = []
    if literal:
        yield True, "\n".join(literal)


def escaped(text: str) -> str:
    """Return prose with code between backticks made code, and all else meaning itself."""
    parts, end = [], 0
    for found in QUOTED.finditer(text):
        parts += [plain(text[end : found.start()]), code(found.group())]
        end = found.end()
    return "".join([*parts, plain(text[end:])])


def plain(text: str) -> str:
    """Return prose whose signs mean nothing to Sphinx."""
    return SPECIAL.sub(lambda found: "\\" + found.group(), text)


def code(quoted: str) -> str:
    """Return a name as a reference, anything else as code."""
    inner = quoted.strip("`")
    return f"`{inner}`" if NAME.fullmatch(inner) else f"``{inner}``"


def fields_of(cls: type) -> list[str]:
    """Return a google-style section with what the comments say about the fields of a record."""
    if not (is_dataclass(cls) or hasattr(cls, "_fields")):
        return []
    tree, comments = parsed(inspect.getsource(cls))
    (record,) = tree.body
    assert isinstance(record, ast.ClassDef)
    fields = [
        f"    {node.target.id} ({plain(ast.unparse(node.annotation))}): {escaped(said)}"
        for node in record.body
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
        if (said := comments.get(node.end_lineno or 0)) and not node.target.id.startswith("_")
    ]
    return ["", "Fields:", *fields] if fields else []


def constants_of(module: Any) -> list[str]:
    """Return descriptions of the public constants that a module defines."""
    source = inspect.getsource(sys.modules[module.__name__])
    tree, comments = parsed(source)
    lines: list[str] = []
    for node, following in pairwise([*tree.body, ast.Pass()]):
        target = assigned(node)
        if isinstance(following, ast.Expr):
            continue  # it has a docstring, which autodoc knows
        if not re.fullmatch(r"[A-Z][A-Za-z0-9_]*", target) or not hasattr(module, target):
            continue
        value = ast.unparse(node.value)  # type: ignore[attr-defined]
        shown = [f"   :value: {value}"] if len(value) <= LONGEST_VALUE else []
        said = comments.get(node.end_lineno or 0) or comments.get(node.lineno) or ""
        lines += ["", f".. py:data:: {target}", *shown, "", f"   {escaped(said)}"]
    return lines


def assigned(node: ast.stmt) -> str:
    """Return the name to which a statement assigns a value, or nothing."""
    if isinstance(node, ast.Assign) and len(node.targets) == 1:
        target = node.targets[0]
    elif isinstance(node, ast.AnnAssign) and node.value is not None:
        target = node.target
    else:
        return ""
    return target.id if isinstance(target, ast.Name) else ""


def parsed(source: str) -> tuple[ast.Module, dict[int, str]]:
    """Return the tree of a piece of source, and its comments by their line."""
    text = textwrap.dedent(source)
    tokens = tokenize.generate_tokens(StringIO(text).readline)
    comments = {
        token.start[0]: token.string.lstrip("# ")
        for token in tokens
        if token.type == tokenize.COMMENT and "noqa" not in token.string
    }
    return ast.parse(text), comments

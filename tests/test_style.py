"""Docstrings name things, and no page or docstring cites a document that is not there."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted(path for room in ("hazbot_gym", "tests") for path in (ROOT / room).rglob("*.py"))
PAGES = sorted((ROOT / "docs").glob("*.md"))

QUESTION = re.compile(r"(Return )?(what|how|who|whose|whom|where|whether)\b", re.IGNORECASE)
ABSENT = re.compile(r"\b(SPEC|EVALUATION|DESIGN|HOUSE|EVIDENCE)\b")
LINK = re.compile(r"\]\(([^)\s]+)\)")
FILE = re.compile(r"`((?:hazbot_gym|configs|benchmarks|docs|tests|train|eval)/[\w./-]+\.\w+)`")
PROSE = (*PAGES, *ROOT.glob("*.md"), *(ROOT / "train").glob("*.md"))
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def docstrings(text: str) -> Iterator[tuple[int, str]]:
    """Yield the first line and text of each docstring."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, DOCUMENTED) and (found := ast.get_docstring(node)):
            yield node.body[0].lineno, found


def comments(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each comment."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string


def questions(text: str) -> list[str]:
    """Return the docstrings that open with a question word instead of a noun or verb."""
    return [f"{line}: {found[:60]}" for line, found in docstrings(text) if QUESTION.match(found)]


def citations(text: str) -> list[str]:
    """Return the docstrings and comments that cite a document outside the repository."""
    found = (*docstrings(text), *comments(text))
    return [f"{line}: {each}" for line, each in found if ABSENT.search(each)]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub and MyST make them."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.M)
    titles = re.findall(r"^#{1,6} (.+)$", text, re.MULTILINE)
    slugs = (re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-") for title in titles)
    return set(slugs) | set(re.findall(r"^\(([\w.-]+)\)=$", text, re.MULTILINE))


def has_anchor(page: Path, anchor: str) -> bool:
    """Return True if a page has a heading of this anchor, or headings that the site adds."""
    text = page.read_text(encoding="utf-8")
    return anchor in anchors(page) or "<!-- made: " in text or "```{include}" in text


def broken_links(page: Path) -> list[str]:
    """Return the links of a page to files or headings that are missing."""
    broken = []
    for link in LINK.findall(page.read_text(encoding="utf-8")):
        path, _, anchor = link.partition("#")
        if re.match(r"[a-z]+:", link):
            continue
        target = page.parent / path if path else page
        if not target.exists() or (
            anchor and target.suffix == ".md" and not has_anchor(target, anchor)
        ):
            broken.append(link)
    return broken


def test_the_checks_find_what_they_look_for(tmp_path: Path) -> None:
    assert questions('"""What it is."""\n')
    assert questions('def f():\n    """Return whether it is."""\n')
    assert not questions('"""Whatever."""\ndef f():\n    """Return the place where it is."""\n')
    assert citations("x = 1  # SPEC A3\n")
    assert citations('"""As in DESIGN."""\n')
    assert not citations('"""Design."""\nx = "SPEC"\n')
    page = tmp_path / "page.md"
    page.write_text("# A title\n[a](#a-title) [b](#b) [c](gone.md) [d](https://example.org)\n")
    assert broken_links(page) == ["#b", "gone.md"]


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_docstrings_name_the_thing_and_cite_documents_that_exist(source: Path) -> None:
    text = source.read_text(encoding="utf-8")
    assert questions(text) == []
    assert citations(text) == []


@pytest.mark.parametrize("page", PROSE, ids=lambda path: path.name)
def test_links_of_pages_lead_somewhere(page: Path) -> None:
    assert broken_links(page) == []


@pytest.mark.parametrize("page", PROSE, ids=lambda path: path.name)
def test_files_that_pages_name_are_there(page: Path) -> None:
    named = FILE.findall(page.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []

"""Every block of the documentation is parsed, and does what the page shows."""

from __future__ import annotations

import ast
import re
import shlex
import tomllib
from itertools import takewhile

import pytest
import typer

from docs.page_blocks import Block, blocks_of, hand_written_pages
from docs.page_runs import run_page
from stiffcal.cli.command_tree import COMMANDS, command_named
from tests.laboratory.documentation import indented_blocks

TAGS = {"run", "output", "file", "check", "show"}
MOST_SHOWN = 0.1
ANYTHING = "…"
OPERATORS = {"|", "||", "&&", ">", ";"}
HERE_DOCUMENT = re.compile(r"(?<=<<'END_OF_SCRIPT'\n).*?\nEND_OF_SCRIPT\n", re.DOTALL)
ALL = [block for page in hand_written_pages() for block in blocks_of(page)]
COMMAND_PAGES = sorted({block.page for block in ALL if block.tag == "run"})


def label(block: Block) -> str:
    return f"{block.page}:{block.line}"


def test_every_block_has_a_tag() -> None:
    assert [label(block) for block in ALL if block.tag not in TAGS] == []
    assert {page: lines for page in hand_written_pages() if (lines := indented_blocks(page))} == {}


def test_few_blocks_are_only_shown_and_each_of_them_has_a_reason() -> None:
    shown = [block for block in ALL if block.tag == "show"]
    assert [label(block) for block in shown if not block.reason] == []
    assert len(shown) <= MOST_SHOWN * len(ALL)


@pytest.mark.parametrize("block", [block for block in ALL if block.language == "toml"], ids=label)
def test_toml_is_valid(block: Block) -> None:
    assert tomllib.loads(block.text)


@pytest.mark.parametrize("block", [block for block in ALL if block.language == "python"], ids=label)
def test_python_is_valid(block: Block) -> None:
    assert ast.parse(block.text).body


def commands_in(block: Block) -> list[list[str]]:
    """Return the words of every call of stiffcal in a shell block, without comments and settings of variables."""
    calls = []
    for line in HERE_DOCUMENT.sub("", block.text).replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if "stiffcal" in words:
            call = words[words.index("stiffcal") + 1 :]
            calls.append(list(takewhile(lambda word: word not in OPERATORS, call)))
    return calls


def parse(words: list[str]) -> None:
    """Parse a call as the command line would; an unknown command or option raises."""
    name, *arguments = words
    assert name in COMMANDS, name
    command_named(name).make_context(name, arguments)


SHELL = [block for block in ALL if block.language == "sh"]


@pytest.mark.parametrize("block", SHELL, ids=label)
def test_commands_exist_with_their_options(block: Block) -> None:
    for words in commands_in(block):
        parse(words)


def test_an_unknown_option_is_noticed() -> None:
    with pytest.raises(typer.TyperException):
        parse(["check", "--no-such-option"])


def agrees(printed: list[str], shown: list[str]) -> bool:
    """Whether printed lines are those that a page shows; a line `…` of the page matches any lines."""
    if not shown:
        return not printed
    if shown[0].strip() == ANYTHING:
        return any(agrees(printed[start:], shown[1:]) for start in range(len(printed) + 1))
    return bool(printed) and printed[0].rstrip() == shown[0].rstrip() and agrees(printed[1:], shown[1:])


def test_lines_agree_only_with_themselves_and_with_the_ellipsis() -> None:
    assert agrees(["a", "b", "c"], ["a", ANYTHING, "c"])
    assert agrees(["a"], ["a", ANYTHING])
    assert not agrees(["a", "b"], ["a"])
    assert not agrees(["a", "b"], [ANYTHING, "c"])


@pytest.mark.docs
@pytest.mark.parametrize("page", COMMAND_PAGES)
def test_a_page_s_commands_print_what_it_shows(page: str) -> None:
    """All blocks of one page, in order, in one folder; the build takes the page's pictures from the same run."""
    done = run_page(page)
    printed = ""
    for block in blocks_of(page):
        if block.tag == "run":
            printed = done.printed[block.line]
        elif block.tag == "output":
            lines, shown = printed.rstrip().splitlines(), block.text.rstrip().splitlines()
            assert agrees(lines, shown), f"{label(block)} prints:\n{printed}"
    assert all(picture.stat().st_size for picture in done.pictures.values())

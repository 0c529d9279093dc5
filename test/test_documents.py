# Copyright 2026 hijack_detect maintainers. Licensed under Apache-2.0, see LICENSE.
"""The documents: links lead somewhere, and the commands in them exist with their options."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import pytest
from command import hijack_detect
from ros import ROOT

from hijack_detect.cli.main import COMMANDS

DOCUMENTS = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")])
LINK = re.compile(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)")
COMMAND = re.compile(r"^\s*(?:\.venv/bin/)?hijack-detect ([a-z]+)(.*)$", re.MULTILINE)
FILE = re.compile(r"`((?:hijack_detect|test|experiments|tools|stress|benchmarks)/[\w./]+\.py)`")
OPTION = re.compile(r"(?<=\s)--[a-z][a-z-]*")


def anchors(text: str) -> set[str]:
    """The anchors of the headings, as they are made on a page."""
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", one).lower() for one in headings)
    return {re.sub(r"[^\w\- ]", "", one).strip().replace(" ", "-") for one in plain}


@lru_cache
def help_of(command: str) -> str:
    done = hijack_detect(command, "--help")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_to_files_and_headings(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    for target, anchor in LINK.findall(re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
        if target.startswith(("http:", "https:")):
            continue
        path = (document.parent / target).resolve() if target else document
        assert path.exists(), f"{document.name}: {target}"
        if anchor and path.suffix == ".md":
            found = anchors(path.read_text(encoding="utf-8"))
            assert anchor in found, f"{document.name}: {target}#{anchor}"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_files_that_are_named_exist(document: Path) -> None:
    for path in FILE.findall(document.read_text(encoding="utf-8")):
        assert document.name == "CHANGELOG.md" or (ROOT / path).exists(), f"{document.name}: {path}"


def test_commands_have_the_options_that_the_documents_give_them() -> None:
    for document in DOCUMENTS:
        for command, rest in COMMAND.findall(document.read_text(encoding="utf-8")):
            assert command in COMMANDS, f"{document.name}: hijack-detect {command}"
            for option in OPTION.findall(rest.partition("#")[0]):
                where = f"{document.name}: hijack-detect {command} {option}"
                assert option in help_of(command), where

# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""README and pages of doc/ as data: their fenced examples, the files they are meant to be, and the commands in them."""
import re
import textwrap
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
# The first line of a file's example is a comment with its path.
FILE_NAME = re.compile(r"\s*(?:#|<!--)\s*([\w./]+\.\w+)\s*(?:-->)?\n")
FILES = {"yaml", "xml", "cmake"}
ALL_LANGUAGES = FILES | {"sh", "text"}


def pages():
    """{path: text} of the README and of the pages that it leads to, in a fixed order."""
    return {path: path.read_text() for path in [PACKAGE / "README.md", *sorted(PACKAGE.glob("doc/*.md"))]}


def text():
    """All pages, one after the other."""
    return "\n".join(pages().values())


def blocks(markdown):
    """[(language, text)] of all fenced examples, in their order."""
    return [(match[2], textwrap.dedent(match[3])) for match in FENCE.finditer(markdown)]


def files(markdown):
    """{path: contents} of the examples that are files."""
    found = {}
    for language, contents in blocks(markdown):
        if language in FILES:
            name = FILE_NAME.match(contents)
            if not name:
                raise ValueError(f"an example in {language} does not begin with its file's name:\n{contents}")
            found[name[1]] = contents
    return found


def commands(markdown):
    """All shell commands, each in one line and without its comment."""
    lines = [line for language, contents in blocks(markdown) if language == "sh"
             for line in contents.replace("\\\n", " ").splitlines()]
    stripped = [re.sub(r"\s+# .*", "", line).strip() for line in lines]
    return [re.sub(r"\s+", " ", line) for line in stripped if line]

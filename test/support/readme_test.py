#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""README and pages name what there is: their links lead somewhere, their tables hold each status, reason and key.
(What their examples do is tested by test/install.)"""
import re
import unittest

import readme
from check_contracts import part_keys
from readme import PACKAGE


def constants(path, section=0):
    """Names of the constants of a message, or of one section of a service."""
    return re.findall(r"^uint8 (\w+) *=", (PACKAGE / path).read_text().split("\n---\n")[section], re.MULTILINE)


class Blocks(unittest.TestCase):
    MARKDOWN = "1. x\n\n   ```sh\n   a \\\n     b  # why\n   c\n   ```\n\n```yaml\n# d/e.yaml\nf: 1\n```\n"

    def test_are_read_as_commands(self):
        self.assertEqual(readme.commands(self.MARKDOWN), ["a b", "c"])

    def test_are_read_as_files(self):
        self.assertEqual(readme.files(self.MARKDOWN), {"d/e.yaml": "# d/e.yaml\nf: 1\n"})

    def test_without_a_name_are_refused(self):
        with self.assertRaises(ValueError):
            readme.files("```yaml\nf: 1\n```\n")


class Readme(unittest.TestCase):
    def setUp(self):
        self.text = readme.text()

    def rows(self, heading):
        """First cells of the table below `| heading | ...`."""
        table = re.search(rf"^\| {heading} \|.*\n\|[-|]+\n((?:\|.*\n)+)", self.text, re.MULTILINE)
        self.assertTrue(table, heading)
        return re.findall(r"`(\w+)`", " ".join(row.split("|")[1] for row in table[1].splitlines()))

    def test_every_example_has_a_known_language(self):
        fences = re.findall(r"^ *```(\w*)$", self.text, re.MULTILINE)
        self.assertEqual(set(fences[0::2]) - readme.ALL_LANGUAGES, set())
        self.assertEqual(set(fences[1::2]), {""})
        # An indented example would be run by no test.
        outside = readme.FENCE.sub("", self.text)
        self.assertNotRegex(outside, r"\n\n    +\S")

    @staticmethod
    def headings(path):
        return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
                for heading in re.findall(r"^#+ (.*)", path.read_text(), re.MULTILINE)}

    def test_links_lead_somewhere(self):
        links = [(page, *re.fullmatch(r"([^#]*)#?(.*)", link).groups())
                 for page, text in readme.pages().items() for link in re.findall(r"\]\(([^)]+)\)", text)]
        self.assertGreater(len(links), 40)
        for page, file, heading in links:
            path = (page.parent / file).resolve() if file else page
            self.assertTrue(path.exists(), f"{page.name}: {file}")
            if heading:
                self.assertIn(heading, self.headings(path), f"{page.name}: {file}#{heading}")

    def test_readme_leads_to_every_page(self):
        links = set(re.findall(r"\]\((doc/[^)#]+\.md)", readme.pages()[PACKAGE / "README.md"]))
        self.assertEqual(links, {f"doc/{path.name}" for path in (PACKAGE / "doc").glob("*.md")})

    def test_named_paths_exist(self):
        paths = re.findall(r"`((?:test|config|src|msg|srv|launch|include)/[\w./]*)`", self.text)
        paths += ["launch/" + name for name in re.findall(r"`(\w+\.launch)", self.text)]
        self.assertGreater(len(paths), 10)
        for path in paths:
            self.assertTrue((PACKAGE / path).exists(), path)

    def test_launch_files_are_all_named(self):
        for path in (PACKAGE / "launch").iterdir():
            self.assertIn(f"`{path.name}`", self.text)

    def test_each_status_has_its_remedy(self):
        self.assertEqual(self.rows("status"), constants("srv/LocatePart.srv", 1))

    def test_each_reason_has_its_remedy(self):
        self.assertEqual(self.rows("reason"), constants("msg/RefusedPart.msg"))

    def test_each_key_of_a_part_file_is_explained(self):
        self.assertEqual(set(self.rows("key")), part_keys(PACKAGE))

    def test_default_layers_are_those_of_the_code(self):
        header = (PACKAGE / "include/planar_bin_picking/drawing/drawing.h").read_text()
        for name in ("skip_layers", "print_layers"):
            patterns = [pattern.encode().decode("unicode_escape") for pattern in
                        re.findall(r'"([^"]+)"', re.search(name + r" = \{([^}]*)\}", header)[1])]
            row = re.search(rf"^\| `{name}` \|(.*)", self.text, re.MULTILINE)[1]
            self.assertEqual(re.findall(r"`([^`]+)`", row), patterns)


if __name__ == "__main__":
    unittest.main()

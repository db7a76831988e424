# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the tests' files name, with comments left out: fields, constants, texts and trees of parameters."""
import ast
import re
import xml.etree.ElementTree as ElementTree

import yaml

CPP_COMMENT_OR_STRING = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\((.*?)\)\1"|"((?:\\.|[^"\\\n])*)"|\'(?:\\.|[^\'\\\n])\'', re.DOTALL)


class Named:
    """What one file names."""

    def __init__(self):
        self.identifiers = set()  # of types: which messages the file is about
        self.fields = set()  # (owner, field), the owner being the word before the point
        self.keywords = set()  # (function, field), of calls in Python
        self.constants = set()  # (class, constant)
        self.texts = set()
        self.parameters = set()  # that the file reads
        self.trees = []  # flattened {path: value} of mappings

    def add_tree(self, tree):
        if isinstance(tree, dict):
            self.trees.append(dict(flatten(tree)))

    def add_text(self, text):
        self.texts.add(text)
        if ":" in text:
            try:
                self.add_tree(yaml.safe_load(text))
            except (yaml.YAMLError, ValueError, RecursionError):
                pass  # most texts with a colon are no YAML, and some are made to be none


def flatten(tree, prefix="", seen=None):
    """(path, value) of every leaf, and of every inner node with value None; lists of mappings count by their keys.
    Each mapping counts once, since one may hold itself."""
    seen = set() if seen is None else seen
    if id(tree) in seen:
        return
    seen.add(id(tree))
    for key, value in tree.items():
        path = f"{prefix}{key}"
        if isinstance(value, dict):
            yield path, None
            yield from flatten(value, path + "/", seen)
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            yield path, None
            for item in value:
                if isinstance(item, dict):
                    yield from flatten(item, path + "/", seen)
        else:
            yield path, value


def read_cpp(text):
    named = Named()

    def blank(match):
        literal = match[2] if match[2] is not None else match[3]
        if literal is not None:
            named.add_text(literal.replace("\\n", "\n").replace('\\"', '"'))
        return ' "" '

    code = CPP_COMMENT_OR_STRING.sub(blank, text)
    named.parameters = set(re.findall(r'\b(?:param|getParam|required)(?:<[^;(]*>)?\(\s*"~?([\w/]+)"', text))
    named.identifiers = set(re.findall(r"\b[A-Z]\w*", code))
    named.fields = set(re.findall(r"(\w+)(?:\(\)|\[[^\]]*\])?\s*(?:\.|->)\s*(?=([a-z]\w*))", code))
    named.constants = set(re.findall(r"\b(\w+)::([A-Z][A-Z_0-9]*)\b", code))
    # Response::OK of LocatePart::Response::OK belongs to the service.
    named.constants |= {(owner + part, name) for owner, part, name in
                        re.findall(r"\b(\w+)::(Request|Response)::([A-Z][A-Z_0-9]*)\b", code)}
    return named


class PythonNames(ast.NodeVisitor):
    def __init__(self):
        self.named = Named()
        self.other_names = {}  # alias -> what it stands for

    def resolve(self):
        """Constants and keywords under the names of what aliases stand for."""
        for names in (self.named.constants, self.named.keywords):
            names |= {(self.other_names[owner], name) for owner, name in names if owner in self.other_names}
        return self.named

    @staticmethod
    def last_word(node):
        while isinstance(node, (ast.Subscript, ast.Call)):
            node = node.value if isinstance(node, ast.Subscript) else node.func
        return getattr(node, "attr", getattr(node, "id", ""))

    def visit_Attribute(self, node):
        owner = self.last_word(node.value)
        (self.named.constants if node.attr.isupper() else self.named.fields).add((owner, node.attr))
        self.named.identifiers.add(node.attr)
        self.generic_visit(node)

    def visit_Name(self, node):
        self.named.identifiers.add(node.id)

    def visit_ImportFrom(self, node):
        self.named.identifiers.add(node.module)
        self.generic_visit(node)

    def visit_alias(self, node):
        self.named.identifiers.add(node.name)
        if node.asname:
            self.other_names[node.asname] = node.name

    def visit_Assign(self, node):
        if isinstance(node.value, (ast.Name, ast.Attribute)):
            for target in node.targets:
                self.other_names[self.last_word(target)] = self.last_word(node.value)
        self.generic_visit(node)

    def visit_Call(self, node):
        function = self.last_word(node.func)
        if function in ("get_param", "param") and node.args and isinstance(node.args[0], ast.Constant):
            self.named.parameters.add(str(node.args[0].value).lstrip("~"))
        self.named.keywords |= {(function, keyword.arg) for keyword in node.keywords if keyword.arg}
        self.generic_visit(node)

    def visit_Constant(self, node):
        if isinstance(node.value, str):
            self.named.add_text(node.value)

    def visit_Dict(self, node):
        try:
            self.named.add_tree(ast.literal_eval(node))
        except ValueError:
            # With values that are not literals; the keys are.
            self.named.add_tree({key.value: 0 for key in node.keys
                                 if isinstance(key, ast.Constant) and isinstance(key.value, str)})
        self.generic_visit(node)

    def without_docstring(self, node):
        if ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:] or [ast.Pass()]
        self.generic_visit(node)

    visit_Module = visit_ClassDef = visit_FunctionDef = without_docstring


def read_python(text):
    visitor = PythonNames()
    visitor.visit(ast.parse(text))
    return visitor.resolve()


def read_launch(text):
    """A .test: its parameters. The parser leaves comments out."""
    named = Named()
    for element in ElementTree.fromstring(text).iter():
        named.texts |= set(element.attrib.values())
        if element.tag == "param":
            named.add_tree({element.get("name"): number(element.get("value", ""))})
        if element.tag == "rosparam" and element.text:
            tree = yaml.safe_load(element.text)
            # cases/<name>/... of a tester: what is below a name of a case counts by itself.
            named.add_tree(tree if isinstance(tree, dict) else {element.get("param", ""): tree})
            for value in tree.values() if isinstance(tree, dict) else []:
                named.add_tree(value)
    return named


def set_by_launch_files(text, package):
    """A .test that gives a launch file an argument sets the parameters that are made of it."""
    root = ElementTree.fromstring(text)
    values = {f"$(arg {arg.get('name')})": arg.get("value", arg.get("default", "")) for arg in root.iter("arg")}
    for include in root.iter("include"):
        launch = re.search(r"launch/\w+\.launch$", values.get(include.get("file"), include.get("file")))
        given = {f"$(arg {arg.get('name')})" for arg in include.iter("arg")}
        if launch and (package / launch[0]).exists():
            for param in ElementTree.parse(package / launch[0]).getroot().iter("param"):
                if any(name in param.get("value", "") for name in given):
                    yield param.get("name")


def number(text):
    return yaml.safe_load(text) if re.fullmatch(r"-?[\d.]+", text) else text


def read_yaml(text):
    named = Named()
    named.add_tree(yaml.safe_load(text))
    return named


READERS = {".cpp": read_cpp, ".py": read_python, ".test": read_launch, ".yaml": read_yaml, ".yml": read_yaml}


def read(path):
    named = READERS[path.suffix](path.read_text())
    if path.suffix == ".test":
        for name in set_by_launch_files(path.read_text(), path.parents[2]):
            named.add_tree({name: ""})
    return named

#!/usr/bin/env python3
"""The documentation against what it speaks of: methods' pages have one shape and all keys of the scene file with their
defaults, what they call by the names of the code is there, links lead somewhere, and lines of own code are as told.
usage: test_docs.py SOURCE_FOLDER [TYNDALL]"""
import json
import pathlib
import re
import subprocess
import sys

source = pathlib.Path(sys.argv[1])
program = sys.argv[2] if len(sys.argv) > 2 else None
failures = []
SHAPE = ["When to use it", "When not to", "Options", "What it computes", "From equations to code", "Departures",
         "How well it holds", "How fast it is", "Limits"]


def read(name):
    return (source / name).read_text(encoding="utf-8")


def headings(text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    return re.findall(r"^#+ (.*)$", text, flags=re.M)


def check_shape(method):
    text = read(f"docs/method/{method}.md")
    found = re.findall(r"^## (.*)$", text, flags=re.M)
    if found != SHAPE:
        failures.append(f"docs/method/{method}.md has the sections {found}, not {SHAPE}")


def same_default(schema, words):
    default = schema.get("default")
    word = words.strip().strip("`").strip('"')
    if isinstance(default, bool):
        return word == str(default).lower()
    if isinstance(default, (int, float)):
        try:
            return float(word) == default
        except ValueError:
            return False
    return word == default


def check_options(method, keys):
    text = read(f"docs/method/{method}.md")
    check_generated(method, text)
    table = re.search(rf"^\| key of `render\.{method}` .*?(?=^$)", text, flags=re.M | re.S)
    rows = {} if table is None else dict(re.findall(r"^\| `(\w+)` \|(.*)$", table.group(), flags=re.M))
    if set(rows) != set(keys):
        failures.append(f"docs/method/{method}.md: its keys and the schema's differ in {sorted(set(rows) ^ set(keys))}")
    for key in set(rows) & set(keys):
        values, default = rows[key].split(" | ")[:2]
        if not same_default(keys[key], default):
            failures.append(f"docs/method/{method}.md: {key} has the default {keys[key].get('default')}, not {default}")
        for word in keys[key].get("enum", []):
            if isinstance(word, str) and f'"{word}"' not in values:
                failures.append(f"docs/method/{method}.md: {key} may be {word}, too")


def check_generated(method, text):
    """The table between the marks is what the program prints of its own tables (make docs)."""
    block = re.search(rf"^<!-- options of {method} -->\n\n(.*?)\n\n<!-- end of options of {method} -->$", text, flags=re.M | re.S)
    if block is None:
        failures.append(f"docs/method/{method}.md lacks the marks of 'options of {method}'")
    elif program is not None:
        printed = subprocess.run([program, "help", "--options", method], capture_output=True, text=True, check=True).stdout
        if block.group(1).strip() != printed.strip():
            failures.append(f"docs/method/{method}.md: its options are not those of the program: make docs")


def check_code(page, words, files):
    """What a page calls by the names of the code is there."""
    text = re.sub(r"\S*(?:NAME|ROOM)\S*|room/file\.h", "", page.read_text(encoding="utf-8"))  # they stand for any
    for word in sorted(set(re.findall(r"\b(?:ty|TY)_\w+\b", text)) - words):
        if not word.endswith("_"):
            failures.append(f"{page.relative_to(source)}: there is no {word}")
    for name in sorted(set(re.findall(r"(?<![\w./-])[\w/]+\.(?:k\.h|h|c|cpp|cmake|sh|py)\b", text))):
        if not any(("/" + file).endswith("/" + name) for file in files):
            failures.append(f"{page.relative_to(source)}: there is no {name}")


def anchors(text):
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings(text)}


def check_links(page):
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path) if path else page
        if not there.exists():
            failures.append(f"{page.relative_to(source)}: {target} is not there")
        elif anchor and there.suffix == ".md" and anchor not in anchors(there.read_text(encoding="utf-8")):
            failures.append(f"{page.relative_to(source)}: {target} has no such section")


def check_paths(page):
    """Files and folders that a page names from the root, with wildcards, are there."""
    for path in set(re.findall(r"`((?:src|include|tests|tools|scenes|scripts|cmake)/[\w/.*]*)`", page.read_text(encoding="utf-8"))):
        if not re.search(r"NAME|ROOM", path) and not list(source.glob(path)):
            failures.append(f"{page.relative_to(source)}: there is no {path}")


def check_sizes(page):
    """The page of dependencies tells the lines of own code to a fifth."""
    section = read(page).split("## Own code")[1].split("\n## ")[0]
    rows = [row.split(" | ") for row in re.findall(r"^\| .*`.*$", section, flags=re.M)]
    if len(rows) < 10:
        failures.append(f"{page}: only {len(rows)} rows of own code")
    for cells in rows:
        files = [file for path in re.findall(r"`([\w/.*]+)`", cells[0]) for file in source.glob(path)]
        lines, told = sum(file.read_text(encoding="utf-8").count("\n") for file in files), int(cells[1].replace(",", ""))
        if not files or abs(told - lines) > 0.2 * lines:
            failures.append(f"{page}: {cells[0][2:50]}... has {lines} lines, not {told}")


render = json.loads(read("docs/scene.schema.json"))["$defs"]["render"]["properties"]
for name in [*(name for name, entry in render.items() if "properties" in entry), "impulse"]:
    check_shape(name)
for name, entry in render.items():
    if "properties" in entry:
        check_options(name, entry["properties"])
code = [file for folder in ("include", "src", "tools", "examples", "cmake", "scripts", "tests") for file in sorted((source / folder).rglob("*"))
        if file.is_file()]
words = {word for file in code if file.suffix in (".h", ".c", ".cpp")
         for word in re.findall(r"\b(?:ty|TY)_\w+\b", file.read_text(encoding="utf-8", errors="replace"))}
names = [str(file.relative_to(source)) for file in code]
pages = [source / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")] + sorted((source / "docs").rglob("*.md"))
for page in pages:
    check_code(page, words, names)
    check_paths(page)
check_sizes("docs/dependencies.md")
for markdown in [source / "CHANGELOG.md", *pages]:
    check_links(markdown)
print("\n".join(failures) or "pages have their shape, their keys and their links")
sys.exit(1 if failures else 0)

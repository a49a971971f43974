#!/usr/bin/env python3
"""The documentation against what it speaks of: methods' pages have one shape and all keys of the scene file with their
defaults, what they call by the names of the code is there, and links lead somewhere. usage: test_docs.py SOURCE_FOLDER"""
import json
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1])
failures = []
SHAPE = ["When to use it", "When not to", "Options", "What it computes", "From equations to code", "Departures",
         "How well it holds", "How fast it is", "Limits"]
PAGES = ["path", "screen", "fld", "pop", "lpv", "dom", "impulse"]


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
    if method == "path":
        failures.extend(f"docs/method/path.md lacks render.path.{key}" for key in keys if f"render.path.{key}" not in text)
        return
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


render = json.loads(read("src/io/scenes/scene.schema.json"))["$defs"]["render"]["properties"]
for name in PAGES:
    check_shape(name)
for name, entry in render.items():
    if "properties" in entry:
        check_options(name, entry["properties"])
code = [file for folder in ("include", "src", "tools", "examples", "cmake", "scripts", "tests") for file in sorted((source / folder).rglob("*"))
        if file.is_file()]
words = {word for file in code if file.suffix in (".h", ".c", ".cpp")
         for word in re.findall(r"\b(?:ty|TY)_\w+\b", file.read_text(encoding="utf-8", errors="replace"))}
names = [str(file.relative_to(source)) for file in code]
for page in [source / "README.md", *sorted((source / "docs").rglob("*.md"))]:
    check_code(page, words, names)
for markdown in [source / "README.md", source / "CHANGELOG.md", *sorted((source / "docs").rglob("*.md"))]:
    check_links(markdown)
print("\n".join(failures) or "pages have their shape, their keys and their links")
sys.exit(1 if failures else 0)

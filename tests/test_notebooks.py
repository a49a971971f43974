#!/usr/bin/env python3
"""The notebooks of a folder run from top to bottom, as a kernel would run their cells, and show pictures; in the repository they
have no outputs. usage: PYTHONPATH=BUILD/python test_notebooks.py FOLDER [--keep] (works in the current folder)

--keep writes each picture that a cell shows as NOTEBOOK_CELL.png."""
import ast
import contextlib
import io
import json
import pathlib
import sys

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: python3-numpy is not installed (scripts/setup.sh python)")
    sys.exit(77)


def run_cell(source, name, names):
    """Executes a cell; the value of its last expression, or None."""
    body = ast.parse(source, name).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), name, "exec"), names)
    return eval(compile(ast.Expression(last.value), name, "eval"), names) if last is not None else None


def run(path, keep):
    """The number of pictures and lines that a notebook shows."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    names, pictures, lines = {"__name__": "__main__"}, 0, 0
    for index, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] != "code":
            continue
        if cell["outputs"] or cell["execution_count"] is not None:
            raise SystemExit(f"{path.name}: cell {index} has outputs; clear them")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            shown = run_cell("".join(cell["source"]), f"{path.name}:{index}", names)
        lines += printed.getvalue().count("\n")
        png = getattr(shown, "_repr_png_", lambda: None)()
        if png:
            pictures += 1
            if keep:
                pathlib.Path(f"{path.stem}_{index}.png").write_bytes(png)
        elif keep:
            print(printed.getvalue() + (repr(shown) if shown is not None else ""))
        html = getattr(shown, "_repr_html_", lambda: "")()
        lines += html.count("<tr>")
    return pictures, lines


def main():
    notebooks = sorted(pathlib.Path(sys.argv[1]).glob("*.ipynb"))
    assert len(notebooks) >= 2, "the notebooks were not found"
    for path in notebooks:
        pictures, lines = run(path, "--keep" in sys.argv)
        assert pictures >= 1 and lines >= 1, f"{path.name} shows {pictures} pictures and {lines} lines"
        print(f"{path.name}: {pictures} pictures, {lines} lines of numbers")


main()

#!/usr/bin/env python3
"""Reads every mesh, image and volume in a folder of other people's files and compares it with another reader.

usage: read_all.py [FOLDER] [--tyndall PROGRAM] [--only TEXT] [--kinds LIST] [--jobs N] [--timeout S] [--reasons] [--unchecked]

Each folder inside FOLDER (default: the environment variable TYNDALL_CORPORA) is one corpus. A file is
  right      if its content is that of the other reader,
  unchecked  if it was read but the other reader is missing or cannot read it,
  refused    if `tyndall info` ended with status 2 and one line that says why,
  wrong      if the content differs, or the status or the message does,
  crashed    if a signal or the time limit ended the program.
Other readers: meshes by tests/corpora/meshes.py, images by oiiotool and iinfo (package openimageio-tools), NRRD by unu
(teem-apps), OpenVDB by vdb_print (libopenvdb-tools). The exit status is 1 if a file is wrong or crashed, and 77 without a
folder.
"""
import argparse
import collections
import concurrent.futures
import os
import re
import sys

import compare

KINDS = {
    ".gltf": compare.mesh, ".glb": compare.mesh, ".obj": compare.mesh, ".ply": compare.mesh,
    ".exr": compare.image, ".hdr": compare.image, ".png": compare.image, ".jpg": compare.image, ".jpeg": compare.image,
    ".webp": compare.image, ".nrrd": compare.nrrd, ".nhdr": compare.nrrd, ".vdb": compare.volume, ".nvdb": compare.volume,
}
STATES = ["right", "unchecked", "refused", "wrong", "crashed"]


def files_of(folder):
    for where, _, names in sorted(os.walk(folder, followlinks=True)):
        for name in sorted(names):
            kind = os.path.splitext(name)[1].lower()
            path = os.path.join(where, name)
            if kind in KINDS and os.path.isfile(path):
                yield path, kind


def judge(tools, path, kind):
    """State of one file and the reason for it."""
    status, output, errors = tools.run([tools.tyndall, "info", "--json", "--threads", "1", path])
    if status is None or status < 0:
        return "crashed", "past the time limit" if status is None else f"signal {-status}"
    lines = [line for line in errors.splitlines() if line.startswith("tyndall: ") and ": warning: " not in line[:20]]
    if status == 2 and len(lines) == 1:
        return "refused", lines[0][len("tyndall: "):]
    if status != 0:
        return "wrong", f"status {status}: {errors.strip()[:200]}"
    try:
        fault = KINDS[kind](tools, path, output)
    except compare.Unchecked as reason:
        return "unchecked", str(reason)
    return ("right", "") if fault is None else ("wrong", fault)


def generic(reason, path):
    """A refusal without the names and numbers of one file."""
    reason = reason.replace(path, "").replace(os.path.dirname(path), "")
    reason = re.sub(r"^:?\d*: *", "", reason)
    reason = re.sub(r"cannot open \S+:", "cannot open FILE:", reason)
    reason = re.sub(r"\[\d+\]", "[]", reason)
    return re.sub(r"-?\b\d+(\.\d+)?(e\+?\d+)?\b", "N", reason)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default=os.environ.get("TYNDALL_CORPORA"))
    parser.add_argument("--tyndall", default="build/release/bin/tyndall")
    parser.add_argument("--only", default="", help="files whose path contains this text")
    parser.add_argument("--kinds", default="", help="extensions to read, such as gltf,glb (default: all)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=60, help="seconds per program")
    parser.add_argument("--reasons", action="store_true", help="list what was refused, by reason")
    parser.add_argument("--unchecked", action="store_true", help="list what was not compared")
    options = parser.parse_args()
    if not options.folder or not os.path.isdir(options.folder):
        print("skipped: no folder of files; give one, or set TYNDALL_CORPORA")
        return 77
    tools = compare.Tools(options.tyndall, options.timeout)
    jobs = []
    for corpus in sorted(os.listdir(options.folder)):
        for path, kind in files_of(os.path.join(options.folder, corpus)):
            if options.only in path and kind[1:] in (options.kinds.split(",") if options.kinds else kind[1:]):
                jobs.append((corpus, path, kind))
    counts = collections.defaultdict(collections.Counter)
    reasons = collections.defaultdict(list)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        results = pool.map(lambda job: judge(tools, job[1], job[2]), jobs)
        for (corpus, path, kind), (state, reason) in zip(jobs, results):
            counts[corpus][state] += 1
            counts["all"][state] += 1
            if state in ("wrong", "crashed") or (state == "unchecked" and options.unchecked):
                print(f"{state}: {path}: {reason}", flush=True)
            if state == "refused":
                reasons[kind, generic(reason, path)].append(path)
    print("\n| corpus | files | " + " | ".join(STATES) + " |\n|---|" + "--:|" * (len(STATES) + 1))
    for corpus in sorted(set(counts) - {"all"}) + ["all"]:
        row = [counts[corpus][state] for state in STATES]
        print(f"| {corpus} | {sum(row)} | " + " | ".join(map(str, row)) + " |")
    if options.reasons:
        print("\n| kind | files | reason | example |\n|---|--:|---|---|")
        for (kind, reason), paths in sorted(reasons.items(), key=lambda item: -len(item[1])):
            print(f"| {kind[1:]} | {len(paths)} | {reason} | {os.path.relpath(paths[0], options.folder)} |")
    return 1 if counts["all"]["wrong"] or counts["all"]["crashed"] else 0


if __name__ == "__main__":
    sys.exit(main())

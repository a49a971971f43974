#!/usr/bin/env bash
# Packs the Blender add-on as one zip, which Blender installs.
# usage: scripts/blender_addon.sh OUT.zip
set -euo pipefail
out=$(realpath -m "$1")
cd "$(dirname "$0")/../addons/blender"
mkdir -p "$(dirname "$out")"
rm -f "$out"
/usr/bin/python3 - "$out" <<'PYTHON'
import os, sys, zipfile

with zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED) as archive:
    for name in sorted(os.listdir("tyndall")):
        if not name.endswith((".py", ".toml")):
            continue
        entry = zipfile.ZipInfo(f"tyndall/{name}", (2024, 1, 1, 0, 0, 0))
        entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
        with open(os.path.join("tyndall", name), "rb") as file:
            archive.writestr(entry, file.read())
PYTHON
echo "wrote $out"

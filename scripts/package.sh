#!/usr/bin/env bash
# Builds the Debian packages tyndall, libtyndallVERSION and libtyndall-dev into build/package.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh package
cd build/package
rm -f ./*.deb
cpack > cpack.log 2>&1 || { cat cpack.log >&2; exit 1; }
ls "$PWD"/*.deb
if command -v lintian > /dev/null; then
  lintian --tag-display-limit 0 ./*.deb || true # what it says is for a reader; no tag fails the build
fi

#!/usr/bin/env bash
# Installs what the build needs, if anything is missing (Debian 12 and its relatives).
# usage: scripts/setup.sh [build|fuzz|format|tidy|docs|page|engines|corpora|package|python|blender]...   (default: build)
set -euo pipefail

# a|b: either will do; the first is installed when neither is there.
build=(gcc g++ make cmake ninja-build "pkg-config|pkgconf" libembree-dev libopenexr-dev libimath-dev libblosc-dev
  libopenvdb-dev libnanovdb-dev "libboost-dev|libboost1.74-dev" libtbb-dev libpng-dev libjpeg-dev libwebp-dev zlib1g-dev
  libexpat1-dev libnetcdf-dev
  libjansson-dev libdraco-dev libmeshoptimizer-dev
  libtiff-dev libgdcm-dev libcharls-dev libopenjp2-7-dev libzstd-dev
  libcairo2-dev fonts-dejavu-core libcmocka-dev libcivetweb-dev libturbojpeg0-dev
  libopenmpi-dev openmpi-bin libhypre-dev) # the last three are optional, and CMake says so where they are missing
fuzz=(clang libclang-rt-14-dev)
format=(clang-format)
tidy=(clang-tidy python3)
docs=(doxygen)
package=(dpkg-dev file)
corpora=(python3 openimageio-tools libopenvdb-tools teem-apps) # tests/corpora/read_all.py
python=(python3-dev python3-numpy python3-setuptools python3-wheel python3-pip) # the Python package and its tests
blender=(blender python3-numpy xvfb libgl1-mesa-dri) # tests of the Blender add-on, and its screenshots; several hundred MB
engines=(mono-mcs godot3-server) # tests of the scripts for Unity and Godot
page=("chromium|chromium-browser|google-chrome-stable" python3) # tests of compare's report.html

needed=()
for group in "${@:-build}"; do
  case "$group" in
    build) needed+=("${build[@]}") ;;
    fuzz) needed+=("${fuzz[@]}") ;;
    format) needed+=("${format[@]}") ;;
    tidy) needed+=("${tidy[@]}") ;;
    docs) needed+=("${docs[@]}") ;;
    corpora) needed+=("${corpora[@]}") ;;
    python) needed+=("${python[@]}") ;;
    blender) needed+=("${blender[@]}") ;;
    engines) needed+=("${engines[@]}") ;;
    page) needed+=("${page[@]}") ;;
    package) needed+=("${package[@]}") ;;
    *) echo "setup: unknown group '$group'; known: build, fuzz, format, tidy, docs, page, engines, corpora, package, python, blender" >&2; exit 2 ;;
  esac
done

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "setup: this is not Debian; install what these packages hold, then use cmake directly: ${needed[*]%%|*}" >&2
  exit 2
fi

installed() {
  [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2> /dev/null)" = installed ]
}

missing=()
for choice in "${needed[@]}"; do
  found=no
  for package in ${choice//|/ }; do
    ! installed "$package" || found=yes
  done
  [ $found = yes ] || missing+=("${choice%%|*}")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo > /dev/null; then
    echo "setup: as root, run: apt-get install ${missing[*]}" >&2
    exit 2
  fi
  as_root=(sudo)
fi
echo "setup: installing ${missing[*]}"
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0)
if ! "${apt[@]}" update < /dev/null ||
  ! "${apt[@]}" install -y --no-install-recommends "${missing[@]}" < /dev/null > /dev/null; then
  echo "setup: could not install these packages: ${missing[*]}" >&2
  exit 2
fi

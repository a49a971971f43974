#!/usr/bin/env bash
# Tries the Debian packages in a bare system: installs the tool and renders, installs the development package and builds
# an example by pkg-config and by find_package, removes all of it and looks for what was left. Needs root and the network.
# usage: scripts/try_package.sh [FOLDER OF PACKAGES]   (default: build/package)
set -euo pipefail
cd "$(dirname "$0")/.."
packages=$(realpath "${1:-build/package}")
[ "$(id -u)" -eq 0 ] || { echo "try_package: debootstrap and chroot need root" >&2; exit 2; }
command -v debootstrap > /dev/null || apt-get install -y -qq --no-install-recommends debootstrap > /dev/null
ls "$packages"/*.deb > /dev/null 2>&1 || { echo "try_package: no packages in $packages; make package" >&2; exit 2; }

work=$(mktemp -d)
root=$work/root
clean_up() {
  ! mountpoint -q "$root/proc" || umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap clean_up EXIT
mkdir "$work/packages"
cp "$packages"/*.deb "$work/packages/"
inside() {
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"
}
step() {
  echo "try_package: $*"
}
# quietly COMMAND...: its output is shown when it fails.
quietly() {
  "$@" > "$work/step.log" 2>&1 || { cat "$work/step.log" >&2; echo "try_package: failed: $*" >&2; exit 1; }
}
get() {
  quietly inside apt-get install -y --no-install-recommends "$@"
}
files() { # but for apt's and dpkg's own records
  (cd "$root" && find . -xdev \( -path ./var/lib/dpkg -o -path ./var/lib/apt -o -path ./var/cache -o -path ./var/log \
    -o -path ./proc -o -path ./packages -o -path ./trial \) -prune -o -print | sort)
}

step "a bare system by debootstrap"
# The mirror of this system's own packages.
mirror=${DEBIAN_MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Codename: bookworm' | head -n 1)}
[ -n "$mirror" ] || { echo "try_package: DEBIAN_MIRROR does not name a mirror of Debian" >&2; exit 2; }
quietly debootstrap --variant=minbase bookworm "$root" "$mirror"
mount -t proc proc "$root/proc" # by which the tool finds its programs
mkdir "$root/trial"
cp -r "$work/packages" "$root/packages"
cp -r examples "$root/trial/"
files > "$root/trial/before.txt"

step "the tool"
get $(cd "$root/packages" && printf './packages/%s\n' tyndall_*.deb)
inside tyndall --version
inside tyndall render builtin:demo --spp 4 --size 160x90 -q -o /trial/demo.exr --png /trial/demo.png
inside tyndall info /trial/demo.exr > "$root/trial/info.txt"
grep -q '^size  *160x90$' "$root/trial/info.txt"
inside tyndall figure list > "$root/trial/figures.txt"
grep -q '^screen-truth ' "$root/trial/figures.txt"
for file in usr/share/man/man1/tyndall.1.gz usr/share/man/man1/tyndall-render.1.gz \
  usr/share/bash-completion/completions/tyndall usr/share/doc/tyndall/copyright; do
  [ -s "$root/$file" ] || { echo "try_package: $file is missing" >&2; exit 1; }
done
# The page of the tool is not in minbase's man, which is absent; it is read as text.
zcat "$root/usr/share/man/man1/tyndall.1.gz" > "$root/trial/manual.txt"
grep -q '^\.TH' "$root/trial/manual.txt"

step "the library"
get $(cd "$root/packages" && printf './packages/%s\n' lib*.deb) gcc libc6-dev pkg-config cmake make
inside sh -ec 'cd /trial
  cc -std=c17 examples/01_render.c $(pkg-config --cflags --libs tyndall) -lm -o by_pkg_config
  ./by_pkg_config builtin:cube_g0 by_pkg_config.exr
  cmake -S examples/find_package -B by_cmake > cmake.log
  cmake --build by_cmake > cmake.log
  by_cmake/fog' | tee "$root/trial/out.txt"
grep -q '^transmittance 0.549$' "$root/trial/out.txt"
inside tyndall info /trial/by_pkg_config.exr > "$root/trial/info.txt"
grep -q '^size  *64x48$' "$root/trial/info.txt"

step "removal"
mapfile -t names < <(for file in "$root"/packages/*.deb; do dpkg-deb -f "$file" Package; done)
quietly inside apt-get purge -y "${names[@]}" gcc libc6-dev pkg-config cmake make
quietly inside apt-get autoremove --purge -y
files > "$root/trial/after.txt"
left=$(comm -13 "$root/trial/before.txt" "$root/trial/after.txt")
if grep -i tyndall <<< "$left"; then
  echo "try_package: the files above were left" >&2
  exit 1
fi
inside dpkg --get-selections | { ! grep -i tyndall; }
step "files that other packages left: $(grep -c . <<< "$left" || true)"
step "installed, rendered, built against, removed"

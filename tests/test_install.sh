#!/usr/bin/env bash
# Installs to a scratch prefix, moves it, and builds examples against it through pkg-config and through CMake.
# usage: test_install.sh CMAKE BUILD_FOLDER SOURCE_FOLDER CC (works in the current folder, which it empties)
set -euo pipefail
cmake=$1
build=$2
source=$3
cc=$4
. "$(dirname "$0")/scratch.sh"

"$cmake" --install "$build" --prefix "$PWD/first" > install.log
mv first prefix # nothing may remember where it was installed
prefix=$PWD/prefix

pc=$(find "$prefix" -name tyndall.pc)
library=$(dirname "$(dirname "$pc")")
export LD_LIBRARY_PATH=$library
export PKG_CONFIG_PATH=$library/pkgconfig
unset DESTDIR

version=$("$prefix/bin/tyndall" --version)
[ "$version" = "tyndall $(pkg-config --modversion tyndall)" ] || { echo "versions differ: $version"; exit 1; }
for header in "$source"/include/tyndall/*.h; do
  cmp "$header" "$prefix/include/tyndall/$(basename "$header")"
done

# A manual page for the tool and one for each of its commands.
pages=$prefix/share/man/man1
for command in $("$prefix/bin/tyndall" help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
  grep -q '^\.SH OPTIONS' "$pages/tyndall-$command.1" || { echo "no manual page of $command"; exit 1; }
done
grep -q '^\.BR tyndall' "$pages/tyndall.1" || { echo "no manual page of tyndall"; exit 1; }

# Tools are not beside the command that runs them, and are not missed until they are asked for.
"$prefix/bin/tyndall" bench load --side 8 --runs 1 > bench.out
grep -q '^  nrrd raw:' bench.out || { echo "tyndall bench does not run"; exit 1; }
"$prefix/bin/tyndall" figure list > figures.out
grep -q '^screen-truth ' figures.out || { echo "tyndall figure does not run"; exit 1; }
mv "$prefix/libexec" elsewhere
for tool in bench figure; do
  status=0
  "$prefix/bin/tyndall" "$tool" --help > missing.out 2> missing.err || status=$?
  [ $status = 2 ] || { echo "tyndall $tool without its program: status $status"; exit 1; }
  grep -q "^tyndall: tyndall-$tool is not installed, which 'tyndall $tool' runs$" missing.err || { cat missing.err; exit 1; }
done
"$prefix/bin/tyndall" help --man pages_without_tools
[ -s pages_without_tools/tyndall-render.1 ] || { echo "no manual pages without tools"; exit 1; }
[ ! -e pages_without_tools/tyndall-bench.1 ] || { echo "a manual page of what is not installed"; exit 1; }
mv elsewhere "$prefix/libexec"

completion=$prefix/share/bash-completion/completions/tyndall
grep -q '^complete .* tyndall$' "$completion" || { echo "no completion"; exit 1; }

# check PROGRAM IMAGE: it renders, and the installed tool reads what it wrote.
check() {
  "$1" builtin:cube_g0 "$2"
  "$prefix/bin/tyndall" info "$2" > info.out
  grep -q '^size  *64x48$' info.out || { echo "$2 is not what $1 should write"; exit 1; }
}

# shellcheck disable=SC2046
"$cc" -std=c17 "$source/examples/01_render.c" $(pkg-config --cflags --libs tyndall) -o by_pkg_config
check ./by_pkg_config by_pkg_config.exr

# consume SOURCE_FOLDER: configures and builds a project against the installed package, in consumer/build.
consume() {
  rm -rf consumer/build
  "$cmake" -S "$1" -B consumer/build "-DCMAKE_PREFIX_PATH=$prefix" "-DCMAKE_C_COMPILER=$cc" > consumer.log 2>&1 ||
    { cat consumer.log; return 1; }
  "$cmake" --build consumer/build
}

mkdir consumer
consume "$source/examples/find_package"
[ "$(consumer/build/fog)" = 'transmittance 0.549' ] || { echo "the example project prints $(consumer/build/fog)"; exit 1; }

cat > consumer/CMakeLists.txt << END
cmake_minimum_required(VERSION 3.20)
project(consumer LANGUAGES C)
find_package(tyndall 99 QUIET)
if(tyndall_FOUND)
  message(FATAL_ERROR "version 99 was found")
endif()
find_package(tyndall ${version#tyndall } EXACT REQUIRED)
END
"$cmake" -S consumer -B consumer/build_versions "-DCMAKE_PREFIX_PATH=$prefix" "-DCMAKE_C_COMPILER=$cc" > consumer.log 2>&1 ||
  { cat consumer.log; exit 1; }

# The C++ half of the public headers.
if command -v c++ > /dev/null; then
  # shellcheck disable=SC2046
  c++ -std=c++17 -Wall -Wextra -Werror "$source/examples/06_cpp.cpp" $(pkg-config --cflags --libs tyndall) -o by_cpp
  ./by_cpp
  "$prefix/bin/tyndall" info 06_cpp.exr > info.out
  grep -q '^size  *64x48$' info.out || { echo "06_cpp.exr is not right"; exit 1; }
fi
echo "installed, moved, found twice"

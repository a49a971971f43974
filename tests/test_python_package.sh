#!/usr/bin/env bash
# The Python package as its users install it, without a network: a wheel of one binary interface, whose content imports and
# renders, and a source distribution with all that it needs. With TYNDALL_IN_FULL=1 the module is built anew from that.
# usage: test_python_package.sh PYTHON SOURCE_FOLDER MODULE TYNDALL (works in the current folder, which it empties)
set -euo pipefail
python=$1
source=$2
module=$3
tool=$4
. "$(dirname "$0")/scratch.sh"
for name in pip setuptools wheel; do
  if ! "$python" -c "import $name" 2> /dev/null; then
    echo "skipped: $python has no $name (scripts/setup.sh python)"
    exit 77
  fi
done
pip() {
  "$python" -m pip --no-input --disable-pip-version-check --no-cache-dir "$@"
}

# A copy, because builds leave files beside setup.py.
mkdir project
for part in CMakeLists.txt LICENSE cmake include scenes src; do ln -s "$source/$part" project/; done
cp -r "$source/python" project/
rm -rf project/python/build project/python/*.egg-info project/python/dist

[ -n "${TYNDALL_IN_FULL:-}" ] || export TYNDALL_PYTHON_MODULE=$module TYNDALL=$tool
pip wheel ./project/python --no-build-isolation --no-deps --no-index -w wheels > log.txt 2>&1 || { tail -n 30 log.txt; exit 1; }
wheel=$(ls wheels)
case $wheel in tyndall-[0-9]*-cp311-abi3-linux_*.whl) ;; *) echo "the wheel is called $wheel"; exit 1 ;; esac
pip install --no-deps --no-index --target installed "wheels/$wheel" > log.txt 2>&1 || { cat log.txt; exit 1; }
unset TYNDALL
for file in __init__.py _core.pyi py.typed _core.abi3.so bin/tyndall; do
  [ -f "installed/tyndall/$file" ] || { echo "the wheel lacks $file"; exit 1; }
done
cat > render.py << 'END'
import tyndall
print(tyndall.__file__)
image = tyndall.Scene("builtin:cloud_sun").render("path", size=(8, 6), spp=1)
assert image.size == (8, 6) and image.complete
assert tyndall.tool().endswith("installed/tyndall/bin/tyndall") and "tyndall" in tyndall.run("help")
END
PYTHONPATH=installed "$python" render.py > path.txt
grep -q installed/tyndall path.txt || { echo "another package was imported: $(cat path.txt)"; exit 1; }

(cd project/python && "$python" setup.py -q sdist -d ../../dist) > log.txt 2>&1 || { tail -n 30 log.txt; exit 1; }
tar tzf dist/tyndall-*.tar.gz > files.txt
for file in setup.py pyproject.toml src/module.h src/call.c tyndall/_scene.py project/CMakeLists.txt \
  project/include/tyndall/base.h project/src/base/context.c project/scenes/builtin/cloud_sun.json project/LICENSE; do
  grep -q "^tyndall-[^/]*/$file\$" files.txt || { echo "the source distribution lacks $file"; exit 1; }
done
if [ -n "${TYNDALL_IN_FULL:-}" ]; then
  pip wheel dist/tyndall-*.tar.gz --no-build-isolation --no-deps --no-index -w again > log.txt 2>&1 || { tail -n 30 log.txt; exit 1; }
  [ "$(ls again)" = "$wheel" ]
fi
echo "$wheel and $(wc -l < files.txt) files of sources"

# The few things one wants without knowing the build. Everything below is CMake (CMakePresets.json).
.PHONY: all demo test validate docs figures matrix matrix-fine auto-model performance fuzz tsan tidy format format-check package wheel blender-addon clean
.DEFAULT_GOAL := all

sources = $(shell find include src tools tests examples python -name '*.[ch]' -o -name '*.cpp')

all:
	@scripts/setup.sh
	@scripts/build.sh release

# Installs what is missing, builds, renders out/demo.exr and out/demo.png.
demo:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli
	@mkdir -p out
	@build/release/bin/tyndall render builtin:demo -o out/demo.exr --png out/demo.png

# Installs what is missing, builds, runs all quick tests, also under sanitizers.
test:
	@scripts/setup.sh
	@scripts/test.sh

# The long comparisons with published and converged results, and the report's page in a browser.
validate:
	@scripts/setup.sh
	@scripts/setup.sh python || echo "validate: without Python's packages, the package is not built" >&2
	@scripts/setup.sh page || echo "validate: without a browser, the report's page is not tried" >&2
	@scripts/build.sh release
	@ctest --test-dir build/release -C Validate -L validate --output-on-failure

# The reference of the C API, build/docs/api/index.html, and anew from the tables of options: docs/commands.md, the schema
# of scene files, the options on the methods' pages.
docs:
	@scripts/setup.sh build docs
	@scripts/build.sh release tyndall_cli tyndall_bench tyndall_figure
	@build/release/bin/tyndall help --markdown > docs/commands.md
	@build/release/bin/tyndall help --schema > docs/scene.schema.json
	@mkdir -p out
	@for page in $$(grep -l '^<!-- options of' docs/method/*.md); do method=$$(basename $$page .md) && \
	  build/release/bin/tyndall help --options $$method > out/options.md && \
	  scripts/insert_between_marks.sh $$page "options of $$method" out/options.md || exit 1; done
	@scripts/docs.sh

# All of the papers' figures into out/figures, and what they measured into docs/figures.md. Goes on where it was
# interrupted; TYNDALL_DATA names the folder of third-party data, and FIGURES has further options.
FIGURES =
figures:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli tyndall_figure
	@mkdir -p out
	@build/release/bin/tyndall figure all -o out/figures --keep $(FIGURES)
	@scripts/insert_between_marks.sh docs/figures.md "measured figures" out/figures/summary.md

# Every method on the scenes of the matrix, into docs/matrix.md and the stored table of measurements. MATRIX="--spp 65536"
# makes the stored means of path anew, too, and goes on where that was interrupted; then copy
# out/matrix/matrix_reference.txt to tools/scenes.
MATRIX =
matrix:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli tyndall_figure
	@mkdir -p out
	@build/release/bin/tyndall figure matrix-methods -o out/matrix $(MATRIX)
	@scripts/insert_between_marks.sh docs/matrix.md "measured matrix" out/matrix/matrix/tables.md
	@cp out/matrix/matrix/measured.txt tools/scenes/matrix_measured.txt

# Twelve of these scenes at 160 x 120 pixels, into a stored table of their errors of structure.
matrix-fine:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli tyndall_figure
	@mkdir -p out
	@build/release/bin/tyndall figure matrix-fine -o out/matrix
	@cp out/matrix/matrix/fine.txt tools/scenes/matrix_fine.txt

# The model of method auto, fitted to both tables, and its figures in docs/method/auto.md.
auto-model:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli tyndall_figure
	@mkdir -p out
	@build/release/bin/tyndall figure auto-model -o out/auto
	@cp out/auto/model_table.c src/choose/model_table.c
	@scripts/insert_between_marks.sh docs/method/auto.md "measured auto" out/auto/model_tables.md

# All benches, into docs/performance.json and docs/performance.md, beside what that file held before.
PERFORMANCE = --rounds 3 --runs 1 --spp 16
performance:
	@scripts/setup.sh
	@scripts/build.sh release tyndall_cli tyndall_bench
	@mkdir -p out
	@build/release/bin/tyndall bench all $(PERFORMANCE) $(if $(wildcard docs/performance.json),--baseline docs/performance.json) \
	  -o out/performance.json --markdown out/performance.md
	@cp out/performance.json docs/performance.json
	@scripts/insert_between_marks.sh docs/performance.md "measured times" out/performance.md

# Every fuzz target for FUZZ_SECONDS (default 600).
fuzz:
	@scripts/setup.sh build fuzz
	@scripts/fuzz.sh

# The library's tests under the thread sanitizer; what they leave out there is said in tests/effort.h.
tsan:
	@scripts/setup.sh
	@scripts/build.sh tsan
	@ctest --preset tsan -j "$$(nproc)"

# The checks of .clang-tidy on every file.
tidy:
	@scripts/setup.sh build tidy
	@scripts/tidy.sh

format:
	@scripts/setup.sh format
	@clang-format -i $(sources)

format-check:
	@scripts/setup.sh format
	@clang-format --dry-run --Werror $(sources)

# Debian packages, build/package/*.deb; scripts/try_package.sh tries them in a bare system.
package:
	@scripts/setup.sh build package
	@scripts/package.sh

# The Python package as a wheel, out/*.whl (docs/python.md).
wheel:
	@scripts/setup.sh build python
	@/usr/bin/python3 -m pip wheel ./python --no-build-isolation --no-deps --no-index -w out

# The Blender add-on as a zip that Blender installs, out/tyndall_blender.zip (docs/blender.md).
blender-addon:
	@scripts/blender_addon.sh out/tyndall_blender.zip

clean:
	rm -rf build out

#!/usr/bin/env bash
# tyndall bench from outside: what it keeps, and how it compares. usage: test_cli_bench.sh TYNDALL (empties the current
# folder)
. "$(dirname "$0")/cli.sh"
unset TYNDALL_DATA

# planted FILE VALUES: what --json wrote, with other values for one time.
planted() {
  sed "s|\"nrrd raw/seconds\": .*|\"nrrd raw/seconds\": $2,|" now.json > "$1"
}

test_keeping() {
  expect 0 bench path,load --scenes nosuch --side 12 --runs 1 --rounds 3 -o now.json --progress plain
  said err.txt 'there is no scene "builtin:nosuch"'
  said err.txt '^bench load, round 3 of 3 \(6 of 6\)'
  valid_json now.json
  said now.json '"skipped": "there is no scene'
  said now.json '"format_version": 1,$'
  said now.json '"processors": [1-9]'
  said now.json '"isa": "x86-64'
  said now.json '"date": "20[0-9-]+T[0-9:]+Z"'
  said now.json '"load_before": [0-9n]'
  said now.json '"complete": true'
  said now.json '"vdb zip half/seconds": \[[0-9.e-]+, [0-9.e-]+, [0-9.e-]+\]'
  expect 0 bench load --side 12 --runs 1 --json -q
  valid_json out.txt
  said out.txt '"nrrd gzip": \{$'
  expect 0 bench view --scenes photograph --data nowhere
  said out.txt 'skipped: "rgbd/tum_fr1_color.png and .* are not in the folder of --data"'
  # All that was asked for lacks what it needs.
  expect 2 bench path --scenes nosuch -o none.json
}

test_baseline() {
  planted fast.json '[1e-9, 1e-9, 1e-9]'
  planted slow.json '[1, 0.9, 1.1]'
  planted wide.json '[1e-9, 1e-9, 9]'
  expect 0 bench load --from now.json --baseline now.json
  said out.txt '^against now.json \(.*\): 10 times and rates, 0 new, 0 gone$'
  said out.txt '^load +10 +1\.00 +1\.00 to 1\.00 +0 +0$'
  expect 0 bench load --from now.json --baseline fast.json
  said out.txt '^  slower .*load/nrrd raw/seconds: .*, before 1 ns$'
  expect 0 bench load --from now.json --baseline slow.json
  said out.txt '^  faster .*load/nrrd raw/seconds: .*, before 1 s$'
  # What rounds differ by is no change.
  expect 0 bench load --from now.json --baseline wide.json
  unsaid out.txt '^  (slower|faster)'
  expect 1 bench all --from now.json --baseline fast.json --fail-slower 20
  said err.txt '^tyndall: 1 times and rates are by more than 20 % worse than in fast.json$'
  expect 0 bench load --from now.json --baseline slow.json --fail-slower 20
  expect 0 bench load --from now.json --baseline fast.json --json -q
  valid_json out.txt
  said out.txt '"times_as_slow": [0-9.]+'
  said err.txt '^  slower '
  # What a comparison wrote is read again without it.
  expect 0 bench load --from now.json --baseline fast.json -o compared.json
  said compared.json '"baseline": \{$'
  expect 0 bench load --from compared.json -o again.json
  unsaid again.json '"baseline"'
  # A measurement against it, too.
  expect 0 bench load --side 12 --runs 1 --baseline slow.json
  unsaid err.txt warning
  said out.txt '^  faster .*nrrd raw'
}

test_markdown() {
  expect 0 bench all --from now.json --baseline now.json --markdown tables.md
  said tables.md '^Measured on 20.* in each of 3 rounds\.$'
  said tables.md '^\| path \| 0 \| skipped: there is no scene'
  said tables.md '^\| load \| 10 \| [0-9.]+ \|'
  said tables.md '^\| nrrd raw \| [0-9.]+ [mu]?s \| .* to .* \| 1\.00 \|$'
}

test_refusals() {
  expect 2 bench device
  said err.txt '^tyndall: bench device: name one, as by --device cuda:0$'
  expect 2 bench device --device cuda:-1
  said err.txt '^tyndall: device: "cuda:-1" is none of cpu, host, cuda:N and auto$'
  printf '{"format": "tyndall bench"' > cut.json
  printf '{"version": "0.1.0", "threads": 2}' > other.json
  sed 's/"format_version": 1/"format_version": 7/' now.json > newer.json
  planted short.json '[1, 2]'
  planted order.json '[5, 6, 7]'
  sed 's/"version": "[^"]*"/"version": "0.0.9"/' now.json > older.json
  usage_error 'missing.json' bench load --baseline missing.json --json
  usage_error 'cut.json:1: is not JSON' bench load --baseline cut.json --json
  usage_error "other.json: is no result file of 'tyndall bench --json'" bench load --baseline other.json --json
  usage_error 'newer.json: is of format version 7, and this program reads 1' bench load --baseline newer.json --json
  usage_error 'short.json: its benches are not' bench load --baseline short.json --json
  usage_error 'order.json: its benches are not' bench load --baseline order.json --json
  sed 's/"load": {/"lo\\u001bad": {/' now.json > odd.json
  usage_error 'odd.json: its benches are not' bench load --baseline odd.json --json
  sed 's/"isa": "/"isa": "\\u001b/' now.json > strange.json
  usage_error 'strange.json: its isa is not' bench load --baseline strange.json --json
  usage_error 'nothing of bench fld' bench fld --from now.json
  usage_error "did you mean 'load'" bench path,laod
  usage_error '--baseline' bench load --fail-slower 5
  usage_error 'no/where' bench load -o no/where.json
  usage_error 'rounds' bench load --rounds 0
  expect 0 bench load --from now.json --baseline older.json
  said err.txt '^tyndall: warning: older.json is of version 0.0.9'
  expect 0 bench load --side 10 --runs 1 --baseline now.json
  said err.txt '^tyndall: warning: now.json was measured with other options'
}

# What was measured until then is kept.
# No bench writes lists as deep as this.
test_deep() {
  deep=$(printf '[%.0s' $(seq 40))$(printf ']%.0s' $(seq 40))
  sed "s|\"results\": {|\"results\": {\"deep\": $deep,|" now.json > deep.json
  expect 0 bench load --from deep.json --json -q
  valid_json out.txt
}

test_interrupt() {
  start bench load --side 24 --runs 20 --rounds 32 -o cut_short.json
  sleep 0.5
  kill -INT "$process"
  finished 130
  valid_json cut_short.json
  said cut_short.json '"complete": false'
  said cut_short.json '"nrrd raw/seconds"'
}

test_keeping
test_baseline
test_markdown
test_refusals
test_deep
test_interrupt
no_temporary_files
finish 80

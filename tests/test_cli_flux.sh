#!/usr/bin/env bash
# tyndall flux from outside: files, bands, what it prints, messages; and periodic scenes in other commands.
# usage: test_cli_flux.sh TYNDALL DATA (empties the current folder)
. "$(dirname "$0")/cli.sh"

step='builtin:step_cloud --spp 16 -q'

# rows FILE PATTERN COUNT: so many lines of the file match.
rows() {
  checks=$((checks + 1))
  [ "$(grep -Ec -- "$2" "$1")" -eq "$3" ] || fail "$1 has $(grep -Ec -- "$2" "$1") rows of /$2/, not $3"
}

test_files() {
  expect 0 flux $step --levels 0,125,250 --columns 8x2 --views 0:0,60:180 -o all.csv
  rows all.csv '^band,quantity,height,zenith,azimuth,x,y,R,G,B,error_R,error_G,error_B$' 1
  rows all.csv '^,up,125,,,' 16
  rows all.csv '^,down_(diffuse|direct),250,,,' 32
  rows all.csv '^,absorbed,,,,' 16
  rows all.csv '^,radiance,,60,180,' 16
  rows all.csv '^,down_direct,250,,,[0-9.]+,[0-9.]+,(1|0.99999[0-9]*|1.00000[0-9]*),' 16
  [ "$(wc -l < all.csv)" -eq $((1 + 16 * 12)) ] || fail "all.csv has $(wc -l < all.csv) rows"
  expect 0 flux $step --columns 4x1 -o all.json
  valid_json all.json
  said all.json '"columns": \[4, 1\]'
  said all.json '"height": 250'
  said all.json '"spp": 16,'
  expect 0 flux builtin:step_cloud -q --time 0.2 -o time.json
  said time.json '"spp": [0-9]{1,7}(\.[0-9]+)?,' # what was taken, not the 2^24 that --time allows
  expect 0 flux $step --columns 4x1 -o again.json --threads 1
  checks=$((checks + 2))
  cmp -s all.json again.json || fail "again.json differs: the number of threads changes fluxes"
  expect 0 flux $step --columns 4x1 -o seed.json --seed 1
  ! cmp -s all.json seed.json || fail "seed.json is the same"
}

test_printed_means() {
  expect 0 flux builtin:step_cloud --spp 16
  said out.txt '^levels:'
  said out.txt 'height: 250'
  said out.txt 'down_direct:'
  said out.txt '^absorbed:'
}

# The sum is the bands' weighted one; equal bands are equal, because they have the same random numbers.
test_bands() {
  cat > bands.json << 'END'
[{"name": "thin", "weight": 0.25, "set": {"media[0].sigma_t": 0.004, "media[1].sigma_t": 0.01}},
 {"name": "grey", "weight": 0.5, "set": {"media[1].albedo": 0.9}},
 {"name": "same", "set": {"media[1].albedo": 0.9}}]
END
  expect 0 flux $step --levels 250 --bands bands.json -o bands.csv
  rows bands.csv '^thin,' 4
  rows bands.csv '^sum,' 4
  checks=$((checks + 1))
  awk -F, '$2 == "up" { v[$1] = $8 }
    END { s = 0.25 * v["thin"] + 0.5 * v["grey"] + v["same"]
      exit !(v["grey"] == v["same"] && s > 0 && (v["sum"] - s) ^ 2 < 1e-12 * s ^ 2) }' bands.csv ||
    fail "bands.csv: $(grep ,up, bands.csv)"
  expect 0 flux $step --bands bands.json -o bands.json.json
  valid_json bands.json.json
  echo '[{"name": "440, \"blue\"", "set": {}}]' > quoted.json
  expect 0 flux $step --levels 250 --bands quoted.json -o quoted.csv
  rows quoted.csv '^"440, ""blue""",(up|down_diffuse|down_direct|absorbed),' 4
  echo '{}' > none.json
  echo '[{"name": "a"}]' > short.json
  echo '[{"name": "a", "set": {}, "wieght": 1}]' > key.json
  echo '[{"name": "a", "set": {"media[7].g": 1}}]' > scene.json
  echo '[' > broken.json
  usage_error 'none.json: it is not an array' flux $step --bands none.json
  usage_error 'band 0 needs "name"' flux $step --bands short.json
  usage_error 'unknown key "wieght"' flux $step --bands key.json
  usage_error 'media\[7\]' flux $step --bands scene.json
  usage_error 'broken.json:[0-9]+: ' flux $step --bands broken.json
  usage_error 'absent.json' flux $step --bands absent.json
}

test_messages() {
  usage_error 'extension is not .json or .csv' flux $step -o out.exr
  usage_error "'x' is not a number" flux $step --levels 0,x
  usage_error 'longer than [0-9]+ characters' flux $step --levels "$(seq -f %.17f -s , 1 1000)"
  usage_error '1 is not above the level before it' flux $step --levels 2,1
  usage_error "'1:y' is not ZENITH:AZIMUTH" flux $step --views 1:y
  usage_error 'zenith: 90 is outside' flux $step --views 90
  usage_error 'dielectrics or panes' flux builtin:step_cloud -q --spp 1 -D 'boundary=null' -D \
    'geometry=[{"sphere":{"center":[0,0,0],"radius":1},"material":{"transmission":1,"volume":{}}}]'
}

# What cannot repeat is refused with the file's line, and methods that cannot repeat anything refuse the scene.
test_periodic_scenes() {
  expect 0 info builtin:step_cloud
  said out.txt '^boundary +periodic, x 0 to 500 y 0 to 500 m$'
  expect 0 info builtin:step_cloud --json
  said out.txt '"periodic": "xy"'
  printf '%s\n' '{ "tyndall": 1,' '"boundary": { "periodic": ["x"] },' \
    '"media": [{ "bounds": [[0, 0, 0], [1, 1, 1]], "sigma_s": 1 }],' \
    '"lights": [{ "type": "point", "position": [0, 0, 0], "intensity": 1 }] }' > lamp.json
  usage_error 'lamp.json:2: boundary: periodic: lamps and glowing surfaces' render lamp.json -o lamp.exr
  expect 0 render builtin:step_cloud --size 16x10 --spp 2 -o step.exr -q
  for method in fld pop lpv dom octaves screen; do
    usage_error "$method takes no periodic scenes" render builtin:step_cloud --size 8x8 --method $method -o no.exr -q
  done
  absent no.exr
  expect 0 flux builtin:step_cloud --method dom -D render.dom.resolution=8 -D render.dom.directions=24 -o dom.csv -q
  said dom.csv '^[^,]*,.*absorbed'
  usage_error 'flux.views: dom gives no radiance' flux builtin:step_cloud --method dom --views 0:0 -q
  usage_error 'repeat along both horizontal axes' flux builtin:cube_g0 --method dom -q
  usage_error 'periodic' render builtin:step_cloud --size 8x8 -D 'boundary.periodic=["x","y","z"]' -o no.exr
  usage_error 'did you mean "periodic"' render builtin:step_cloud --size 8x8 -D 'boundary.periodical=["x"]' -o no.exr
  usage_error 'exactly one of "irradiance"' render builtin:step_cloud -D 'lights[0].irradiance=1' -o no.exr
}

run_tests 80

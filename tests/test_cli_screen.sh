#!/usr/bin/env bash
# tyndall screen from outside: identities, distances of every kind, cameras, channels, messages.
# usage: test_cli_screen.sh TYNDALL DATA (empties the current folder; DATA may be missing)
. "$(dirname "$0")/cli.sh"
data=${TYNDALL_DATA:-$2}

nothing='{"sigma_s": 0, "sigma_a": 0}'
absorber='{"sigma_s": 0, "sigma_a": [0.05, 0.1, 0.2]}'
murky='{"sigma_s": [0.3, 0.4, 0.5], "sigma_a": [0.05, 0.1, 0], "g": 0.8}'

# made FILE W H CHANNEL=V,V,...: an EXR of floats, whose pixels take the values in turn; channels sorted by name.
made() {
  python3 - "$@" << 'PY'
import struct, sys
file, w, h = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
planes = [(a.split('=')[0], [float(v) for v in a.split('=')[1].split(',')]) for a in sys.argv[4:]]
text = lambda s: s.encode() + b'\0'
attribute = lambda name, kind, data: text(name) + text(kind) + struct.pack('<i', len(data)) + data
window = struct.pack('<4i', 0, 0, w - 1, h - 1)
channels = b''.join(text(name) + struct.pack('<iBBBBii', 2, 0, 0, 0, 0, 1, 1) for name, _ in planes) + b'\0'
header = struct.pack('<ii', 20000630, 2) + attribute('channels', 'chlist', channels)
header += attribute('compression', 'compression', b'\0') + attribute('dataWindow', 'box2i', window)
header += attribute('displayWindow', 'box2i', window) + attribute('lineOrder', 'lineOrder', b'\0')
header += attribute('pixelAspectRatio', 'float', struct.pack('<f', 1))
header += attribute('screenWindowCenter', 'v2f', struct.pack('<ff', 0, 0))
header += attribute('screenWindowWidth', 'float', struct.pack('<f', 1)) + attribute('owner', 'string', b'me') + b'\0'
line = 8 + 4 * w * len(planes)
with open(file, 'wb') as out:
    out.write(header + b''.join(struct.pack('<q', len(header) + 8 * h + y * line) for y in range(h)))
    for y in range(h):
        row = [v[(y * w + x) % len(v)] for _, v in planes for x in range(w)]
        out.write(struct.pack('<ii', y, line - 8) + struct.pack('<%df' % len(row), *row))
PY
}

# near A B TOLERANCE: |A - B| <= TOLERANCE.
near() {
  checks=$((checks + 1))
  awk -v a="$1" -v b="$2" -v t="$3" 'BEGIN { d = a - b; exit !(a != "" && b != "" && d <= t && -d <= t) }' ||
    fail "'$1' is not '$2' within $3"
}

# range FILE CHANNEL: least, mean and largest value.
range() {
  "$tyndall" info "$1" | awk -v name="$2" '$1 == name { print $2, $3, $4 }'
}

# constant FILE CHANNEL VALUE: within 1e-5 of it everywhere.
constant() {
  read -r least _ most <<< "$(range "$1" "$2")"
  near "${least:-}" "$3" "$(awk "BEGIN { print 1e-5 * $3 }")"
  near "${most:-}" "$3" "$(awk "BEGIN { print 1e-5 * $3 }")"
}

# field NAME FILE: a number of --stats.
field() {
  sed -n "s/^ *\"$1\": \([-0-9.e+]*\),*\$/\1/p" "$2"
}

identical() {
  checks=$((checks + 1))
  cmp -s "$1" "$2" || fail "$1 and $2 differ"
}

test_no_medium_gives_the_input_back() {
  for variant in scatter gather published naive reference; do
    expect 0 screen box.exr -o same.exr --medium "$nothing" --variant $variant
    same box.exr same.exr
  done
  expect 0 screen box.exr box.exr -o same.exr --medium "$nothing"
  same box.exr same.exr
  expect 0 convert box.exr photo.png --exposure 2
  expect 0 screen photo.png depth.png -o back.png --medium "$nothing" --fov-y 40 --distance-scale 0.001
  identical photo.png back.png
  # A rendering's PNG has the curve that tyndall render gives it.
  expect 0 convert box.exr curved.png --curve filmic
  expect 0 screen box.exr -o back.png --medium "$nothing"
  identical curved.png back.png
  expect 0 screen box.exr -o same.exr --png back.png --medium "$nothing" --curve none --exposure 2
  identical photo.png back.png
}

# I' + I0 = exp(-sigma_a D) I; and what is the same everywhere stays so.
test_uniform_stays_uniform() {
  made flat.exr 23 17 B=4 G=2 R=1 depth.Z=3
  for variant in scatter 'gather --filter 2' 'gather --filter 6' naive; do
    # shellcheck disable=SC2086 # options
    expect 0 screen flat.exr -o out.exr --medium "$murky" --fov-y 40 --variant $variant --aov all
    constant out.exr R 0.860708
    constant out.exr G 1.48164
    constant out.exr B 4
  done
  constant out.exr attenuated.R 0.349938
  constant out.exr scattered.R 0.51077
  constant out.exr distance.Z 3
  constant out.exr depth.Z 3
  expect 0 screen flat.exr -o out.exr --medium "$murky" --fov-y 40 --variant reference --aov scattered,attenuated
  constant out.exr scattered.B 3.10748
  unsaid <("$tyndall" info out.exr) '^spread'
}

test_distances() {
  expect 0 screen box.exr -o radial.exr --medium "$absorber" --stats s.json
  said err.txt 'box.exr: [0-9]+ of 2867 pixels have no distance; they count as 1000000 m away'
  valid_json s.json
  near "$(field missing_depth s.json)" "$(sed -n 's/.*: \([0-9]*\) of 2867.*/\1/p' err.txt)" 0
  # The same distances in millimetres, from a PNG.
  expect 0 screen box.exr depth.png -o whole.exr --medium "$absorber" --distance-scale 0.001
  expect 0 diff whole.exr radial.exr
  near "$(awk '$1 == "all" { print $4 }' out.txt)" 0 1e-3
  expect 0 screen box.exr box.exr -o twice.exr --medium '{"sigma_s": 0, "sigma_a": [0.025, 0.05, 0.1]}' --distance-scale 2
  expect 0 diff twice.exr radial.exr
  near "$(awk '$1 == "all" { print $4 }' out.txt)" 0 1e-6
  expect 0 screen box.exr -o near.exr --medium "$absorber" --sky 2.5 -q
  [ ! -s err.txt ] || fail "-q printed: $(cat err.txt)"
  made seen.exr 2 1 B=1 G=1 R=1
  made half.exr 2 1 Z=2,0
  expect 0 screen seen.exr half.exr -o out.exr --medium '{"sigma_s": 0, "sigma_a": 1}' --fov-y 40 --sky 1 --aov distance
  said <(range out.exr R) '^0.135335 .* 0.367879$'
  said <(range out.exr distance.Z) '^1 .* 2$'
  expect 0 screen seen.exr half.exr -o out.exr --medium '{"sigma_s": 0, "sigma_a": 1}' --fov-y 40 --sky fill --aov distance
  said err.txt 'half.exr: 1 of 2 pixels have no distance; they get one from those around'
  said <(range out.exr distance.Z) '^2 2 2$'
  for name in Z depth.V ViewLayer.Depth.Z Distance anything; do
    made named.exr 2 1 $name=2
    expect 0 screen seen.exr named.exr -o out.exr --medium "$absorber" --fov-y 40
    constant out.exr R 0.904837
  done
  made several.exr 2 1 B=9 depth.Z=2
  expect 0 screen seen.exr several.exr -o out.exr --medium "$absorber" --fov-y 40 --distance-channel B
  constant out.exr R 0.637628
}

# The middle of a frame stays where it is when only a part of it is there.
test_cameras() {
  expect 0 render builtin:cornell_fog -o part.exr --size 61x47 --crop 40,30,20x16 --spp 4 --aov depth -q
  for image in box part; do
    expect 0 screen $image.exr -o ${image}_planar.exr --medium "$absorber" --depth-is planar -q
  done
  same box_planar.exr part_planar.exr
  expect 0 screen box.exr -o other.exr --medium "$absorber" --depth-is planar --fov-y 34 -q
  same box_planar.exr other.exr
  expect 0 screen box.exr -o other.exr --medium "$absorber" --depth-is planar --focal 76.865 --center 30.5,23.5 -q
  expect 0 diff box_planar.exr other.exr
  near "$(awk '$1 == "all" { print $4 }' out.txt)" 0 1e-5
  expect 0 screen box.exr -o other.exr --medium "$absorber" --depth-is planar --focal 76.865 --center 3,3 -q
  expect 0 diff box_planar.exr other.exr
  unsaid out.txt '^values that differ: 0$'
  expect 0 info box_planar.exr
  said out.txt '^tyndall.camera.fov_y 34'
}

test_channels() {
  made rich.exr 5 3 A=0.5 B=1 G=1 R=1 Z=2 id.V=7
  expect 0 screen rich.exr -o out.exr --medium fog:10 --fov-y 40
  constant out.exr A 0.5
  constant out.exr id.V 7
  constant out.exr Z 2
  expect 0 info out.exr
  said out.txt '^owner +me$'
  said out.txt '^tyndall.method +screen$'
  said out.txt '^tyndall.screen.variant scatter$'
  said out.txt '^tyndall.screen.medium fog:10$'
  said out.txt '^tyndall.screen.sigma_s 0\.2995'
  said out.txt '^tyndall.version'
  expect 0 screen rich.exr -o out.png --medium fog:10 --fov-y 40
  said err.txt 'rich.exr: alpha is left out'
  # One channel is grey, which a medium colours; a result goes in again.
  made grey.exr 4 4 Y=1
  made two.exr 4 4 Z=2
  expect 0 screen grey.exr two.exr -o out.exr --medium "$absorber" --fov-y 40 --aov all
  constant out.exr B 0.67032
  unsaid <("$tyndall" info out.exr) '^Y '
  expect 0 screen out.exr -o again.exr --medium "$absorber" --aov all
  constant again.exr B 0.449329
}

test_values_are_mended() {
  made broken.exr 4 1 B=1,nan,inf,-1 G=1 R=1 Z=2
  expect 0 screen broken.exr -o out.exr --medium fog:10 --fov-y 40 --stats s.json
  said err.txt 'broken.exr: 3 pixels were negative or not finite'
  near "$(field nonfinite_fixed s.json)" 3 0
  expect 0 diff out.exr out.exr
  said out.txt '^values not finite: +0$'
}

test_odd_sizes() {
  for size in '1 1' '1 9' '9 1' '2 2' '3 1' '17 5'; do
    # shellcheck disable=SC2086 # two numbers
    made odd.exr $size B=1,2 G=1 R=3 Z=5
    for variant in scatter gather naive reference; do
      expect 0 screen odd.exr -o out.exr --medium "$murky" --fov-y 40 --variant $variant
    done
  done
  expect 0 screen odd.exr -o out.exr --medium "$murky" --fov-y 1e-3
  said err.txt 'pixels spread up to .* the image is too small for more$'
}

test_environment() {
  made dark.exr 2 2 B=0 G=0 R=0 Z=1e6
  expect 0 screen dark.exr -o out.exr --medium '{"sigma_s": 3, "sigma_a": 1}' --fov-y 40 --environment 1,2,4
  constant out.exr R 0.75
  constant out.exr B 3
  made map.exr 4 2 B=3 G=3 R=3
  expect 0 screen dark.exr -o out.exr --medium '{"sigma_s": 3, "sigma_a": 1}' --fov-y 40 --environment map.exr
  constant out.exr G 2.25
  # A white furnace stays one.
  made white.exr 4 4 B=2 G=2 R=2 Z=3
  expect 0 screen white.exr -o out.exr --medium '{"sigma_s": 0.7, "sigma_a": 0, "g": 0.5}' --fov-y 40 --environment 2 --balance
  constant out.exr R 2
}

test_gather_options() {
  for options in '--mask none' '--mask step' '--mask-width 0.3' '--level-scale 0.6' --uniform-weights --plain-distance \
    --no-normalise '--levels 3' '--levels auto' '--filter 6'; do
    # shellcheck disable=SC2086 # options
    expect 0 screen box.exr -o out.exr --medium "$murky" --variant gather $options --sky 5 -q
  done
  # The naive method is the gathering one without its protections.
  expect 0 screen box.exr -o naive.exr --medium "$murky" --variant naive -q
  expect 0 screen box.exr -o other.exr --medium "$murky" --variant gather --mask none --uniform-weights --plain-distance -q
  same naive.exr other.exr
  expect 0 screen box.exr -o published.exr --medium "$murky" --variant published -q
  expect 0 screen box.exr -o other.exr --medium "$murky" --variant gather --no-normalise -q
  same published.exr other.exr
}

test_threads_do_not_matter() {
  for variant in scatter gather reference; do
    expect 0 screen box.exr -o one.exr --medium "$murky" --variant $variant --threads 1 -q
    expect 0 screen box.exr -o three.exr --medium "$murky" --variant $variant --threads 3 -q
    same one.exr three.exr
  done
}

test_refusals() {
  usage_error 'through what' screen box.exr -o x.exr
  usage_error 'where to' screen box.exr --medium fog:9
  usage_error 'expected: tyndall screen' screen -o x.exr --medium fog:9
  usage_error 'x.tif: the extension' screen box.exr -o x.tif --medium fog:9
  usage_error 'no/x.exr' screen box.exr -o no/x.exr --medium fog:9
  usage_error 'mud' screen box.exr -o x.exr --medium mud
  usage_error 'sigma_s' screen box.exr -o x.exr --medium '{"sigma_s": -1, "sigma_a": 0}'
  usage_error 'gone.exr' screen gone.exr -o x.exr --medium fog:9
  usage_error 'gone.exr' screen box.exr gone.exr -o x.exr --medium fog:9
  usage_error 'gone.exr' screen box.exr -o x.exr --medium fog:9 --environment gone.exr
  usage_error 'box.exr is 61x47 pixels, and photo_.exr is 2x1' screen box.exr photo_.exr -o x.exr --medium fog:9
  usage_error "box.exr: no channel 'Q'; there are: .*depth.Z" screen box.exr -o x.exr --medium fog:9 --distance-channel Q
  usage_error 'seen.exr: no channel holds distances.*there are: B, G, R$' screen seen.exr -o x.exr --medium fog:9 --fov-y 9
  usage_error 'seen_.exr: which channel is the distance.*there are: B, G, R$' screen seen.exr seen_.exr -o x.exr \
    --medium fog:9 --fov-y 9
  usage_error 'ids.exr: neither R, G and B.*there are: Z, id.V$' screen ids.exr half.exr -o x.exr --medium fog:9 --fov-y 9
  usage_error 'half.exr: one channel cannot be both' screen half.exr -o x.exr --medium fog:9 --fov-y 9
  usage_error 'depth.png: .*0 to 65535.*--distance-scale' screen box.exr depth.png -o x.exr --medium fog:9
  usage_error 'seen.exr: .*--fov-y DEGREES or --focal' screen seen.exr half.exr -o x.exr --medium fog:9
  usage_error 'box_.exr is at 0,0 of a frame of 20x16, and part.exr is at 40,30 of one of 61x47' screen box_.exr part.exr -o x.exr --medium fog:9
  usage_error 'one of them' screen box.exr -o x.exr --medium fog:9 --fov-y 9 --focal 9
  for option in '--focal 0' '--focal 1,2,3' '--focal x' '--center 3' '--center 1e9,0' '--sky far' '--sky 0' \
    '--levels 16' '--levels 1.5' '--filter 3' '--fov-y 180' '--distance-scale 0' '--environment 1,2' '--environment -1' \
    '--aov spreed' '--depth-is flat' '--variant exact' '--mask none' '--mask-width 1' '--no-normalise' '--window 9' \
    '--variant reference --window 0' '--variant gather --spread gaussian' '--variant scatter --level-scale 1'; do
    # shellcheck disable=SC2086 # options
    usage_error . screen box.exr -o x.exr --medium fog:9 $option
  done
  usage_error 'x.png is none' screen box.exr -o x.png --medium fog:9 --aov spread
  usage_error 'x.exr: the extension is not .png' screen box.exr -o y.exr --png x.exr --medium fog:9
  absent x.exr
  absent x.png
  absent y.exr
}

test_interrupt() {
  expect 0 render builtin:cornell_fog -o large.exr --size 256x192 --spp 1 --aov depth -q
  start screen large.exr -o cut.exr --medium '{"sigma_s": 0.3, "sigma_a": 0}' --variant reference --sky 5
  kill -INT "$process"
  finished 130
  absent cut.exr
}

test_photograph() {
  photo="$data/rgbd/tum_fr1_color.png"
  [ -r "$photo" ] || { echo "skipped: no $photo (set TYNDALL_DATA)"; return; }
  expect 0 screen "$photo" "$data/rgbd/tum_fr1_depth.png" -o desk.png --medium jerlov3c --distance-scale 0.0002 \
    --depth-is planar --focal 517.3,516.5 --center 319.1,255.8 --sky fill
  said err.txt 'tum_fr1_depth.png: 58950 of 307200 pixels have no distance'
  present desk.png
}

test_bench() {
  expect 0 bench screen --size 64x48 --runs 1 --json
  cp out.txt bench.json
  said bench.json '"name": "gather 4x4"'
  valid_json bench.json
  said bench.json '"times_stream": [0-9.]+'
}

expect 0 render builtin:cornell_fog -o box.exr --size 61x47 --spp 4 --aov depth,albedo -q
expect 0 convert box.exr depth.png --bits 16 --channel depth.Z --scale 1000
if command -v python3 > /dev/null; then
  made photo_.exr 2 1 Z=1
  made seen.exr 2 1 B=1 G=1 R=1
  made seen_.exr 2 1 B=1 G=1 R=1
  made half.exr 2 1 Z=2,0
  made ids.exr 2 1 Z=1 id.V=1
  made box_.exr 20 16 B=1 G=1 R=1
  for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
else
  echo "skipped: most, no python3 to make images with"
  test_no_medium_gives_the_input_back
  test_threads_do_not_matter
fi
no_temporary_files
finish 40

#!/usr/bin/env bash
# tyndall compare from outside. usage: test_cli_compare.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

test_scene() {
  expect 0 compare builtin:cube_g0 --methods path,path -o new --size 40x30 --spp 4 --reference-spp 64 --seed 3 \
    --stats stats.json
  said out.txt '^path +[01]\.[0-9]+'
  said out.txt '^path-2 +[01]\.[0-9]+'
  for file in errors.json table.md report.html side.png heat_path.png heat_path-2.png view_path.png view_path-2.png \
    view_reference.png path.exr path-2.exr reference.exr; do
    present "new/$file"
  done
  valid_json new/errors.json
  valid_json stats.json
  said stats.json '"scene": "builtin:cube_g0"'
  said new/errors.json '"relative_rmse": 0\.[0-9]'
  said new/errors.json '"spp": 64'
  said new/errors.json '"relative_noise": \{'
  said new/errors.json '"relative_rmse_without_noise": \{'
  said new/errors.json '"command": "tyndall render builtin:cube_g0 --method path --spp 4 --size 40x30 --seed 3 -o path-2.exr"'
  said new/errors.json '"name": "paths"'
  said new/errors.json '"scene_text": ".*tyndall'
  said new/table.md '^\| path-2 \| all \| [01]\.?[0-9]* \|'
  said new/table.md 'noise is [0-9.]+ % of its mean\.$'
  # What each took on its way: at 1 sample, and at all of them.
  checks=$((checks + 1))
  [ "$(grep -A 99 error_against_time new/errors.json | grep -c '"spp": 1,$')" -eq 2 ] || fail "no error at 1 spp"
  # The command lines make the same images.
  expect 0 render builtin:cube_g0 --method path --spp 64 --size 40x30 --seed 4 --aov variance,samples -o once.exr -q
  same once.exr new/reference.exr
  said new/side.png 'PNG'
  same new/path.exr new/path-2.exr
  expect 0 info new/reference.exr
  said out.txt '^tyndall.seed +4$'
  # The same reference again: the numbers are the same, and files are replaced.
  cp new/errors.json before.json
  expect 0 compare builtin:cube_g0 --methods path -o new --spp 4 --seed 3 --reference new/reference.exr -q
  checks=$((checks + 1))
  [ "$(grep -m 1 rel_mse new/errors.json)" = "$(grep -m 1 rel_mse before.json)" ] || fail "other errors than before"
}

test_images() {
  cp new/path.exr 'odd name.exr'
  expect 0 compare new/reference.exr new/path.exr 'odd name.exr' new/reference.exr -o images --exposure 1
  said out.txt '^odd_name '
  said out.txt '^reference-2 +1 +0 +0 +0 +0$'
  present images/heat_odd_name.png
  said images/table.md '^\| reference-2 \| G \| 1 \| 0 \| 0 \| 0 \| 0 \| 64 \|'
  # As `tyndall diff` says.
  expect 0 diff new/path.exr new/reference.exr --json
  rmse=$(grep -m 1 '"rmse"' out.txt | tr -d ' ,')
  checks=$((checks + 1))
  tr -d ' ,' < images/errors.json > images/errors.txt
  grep -qF "$rmse" images/errors.txt || fail "diff says $rmse, compare does not"
}

# page FILE IMAGES: a page whose elements all close, that needs nothing from elsewhere, with so many images inside; what
# it holds is in page.txt: means of R, G and B of each, one line an image.
page() {
  said "$1" '^</html>$'
  unsaid "$1" '(src|href)="?(http|/|[a-z_]+\.)|url\(|@import|fetch\('
  checks=$((checks + 1))
  [ "$(grep -c '^<script type="application/octet-stream" class="pixels"' "$1")" -eq "$2" ] || fail "$1 has not $2 images"
  command -v python3 > /dev/null || return 0
  checks=$((checks + 1))
  python3 - "$1" > page.txt 2>&1 << 'END' || fail "$1: $(tail -n 1 page.txt)"
import base64, html.parser, json, struct, sys, zlib
class Page(html.parser.HTMLParser):
    empty = {"meta", "input"}
    def __init__(self):
        super().__init__()
        self.open, self.names, self.data, self.pixels = [], set(), "", []
    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag not in self.empty: self.open.append((tag, values))
        if "id" in values: assert values["id"] not in self.names, values["id"]
        self.names.add(values.get("id"))
    def handle_endtag(self, tag):
        assert self.open.pop()[0] == tag, tag
    def handle_data(self, text):
        tag, values = self.open[-1] if self.open else ("", {})
        if values.get("id") == "comparison": self.data += text
        if values.get("class") == "pixels":
            if not self.pixels or self.pixels[-1][0] is not values: self.pixels.append((values, []))
            self.pixels[-1][1].append(text)
page = Page()
page.feed(open(sys.argv[1], encoding="utf-8").read())
page.close()
assert not page.open, page.open
report = json.loads(page.data)
width, height, shrink = report["width"], report["height"], report["shrink"]
columns, rows = -(-width // shrink), -(-height // shrink)
assert len(page.pixels) == 1 + len(report["images"])
for values, text in page.pixels:
    packed = zlib.decompress(base64.b64decode("".join(text), validate=True))
    count = len(packed) // 2
    assert count == 3 * columns * rows, count
    halves = bytearray()
    left = 0
    for i in range(count):
        folded = packed[i] | packed[count + i] << 8
        left = (0 if i % columns == 0 else left) + (folded >> 1 ^ -(folded & 1)) & 0xffff
        halves += left.to_bytes(2, "little")
    numbers = struct.unpack(f"<{count}e", halves)
    scale = 2.0 ** int(values["data-exponent"])
    print(*(scale * sum(numbers[c * count // 3:(c + 1) * count // 3]) * 3 / count for c in range(3)))
END
}

# holds LINE IMAGE: the page's image of that line has the mean of the file's, to half floats.
holds() {
  command -v python3 > /dev/null || return 0
  expect 0 info "$2"
  checks=$((checks + 1))
  python3 -c 'import sys
page = [float(word) for word in open("page.txt").read().splitlines()[int(sys.argv[1])].split()]
lines = [line.split() for line in open("out.txt")]
means = [float(line[2]) for name in "RGB" for line in lines if line[0] == name]
assert all(abs(a / b - 1) < 1e-4 for a, b in zip(page, means)), (page, means)' "$1" > holds.txt 2>&1 ||
    fail "$2: $(tail -n 1 holds.txt)"
}

test_page() {
  page new/report.html 2
  holds 0 new/reference.exr
  holds 1 new/path.exr
  said new/report.html '^<title>builtin:cube_g0</title>$'
  said new/report.html '"source": "new/reference.exr",$'
  page images/report.html 4
  holds 2 'odd name.exr'
  # A name that is markup stays text.
  odd='a<b onload=x>"&'\''.exr'
  cp new/path.exr "$odd"
  expect 0 compare "$odd" new/path.exr -o odd -q
  said odd/report.html '"source": "a\\u003cb onload=x>\\"&'\''\.exr",$'
  page odd/report.html 2
  # Wide images are made smaller.
  expect 0 render builtin:cube_g0 -o wide.exr --size 2600x2 --spp 1 -q
  expect 0 compare wide.exr wide.exr -o wide -q
  said wide/report.html '"shrink": 3,'
  page wide/report.html 2
}

# The reference is kept with its state, and gone on from.
test_reference() {
  small="--size 24x16 --spp 1 --reference-noise 0.001"
  # shellcheck disable=SC2086 # options
  expect 0 compare builtin:cube_g0 --methods fld -o kept $small --reference-spp 48 --progress none
  said kept/errors.json '"stored": false'
  said kept/errors.json '"spp": 48,'
  said kept/errors.json '"nearest": "fld",'
  said kept/errors.json '"noise_share": [0-9.]+,'
  said kept/errors.json '"noise_share_wanted": 0\.001'
  said out.txt 'noise is [0-9.]+ % of its mean, [0-9.e-]+ of the smallest difference \(fld, [0-9.]+ %\): not well below'
  # shellcheck disable=SC2086
  expect 0 compare builtin:cube_g0 --methods fld -o kept $small --reference-spp 80 --progress none
  said kept/errors.json '"stored": true'
  said kept/errors.json '"spp": 80,'
  expect 0 render builtin:cube_g0 --method path --spp 80 --size 24x16 --seed 1 --aov variance,samples -o once.exr -q
  same once.exr kept/reference.exr
  # Enough: nothing more is done. Fewer samples than there are do not take any away.
  expect 0 compare builtin:cube_g0 --methods fld -o kept --size 24x16 --spp 1 --reference-noise 10 --reference-spp 20 \
    --progress none
  said kept/errors.json '"spp": 80,'
  said out.txt ': well below it\.$'
  [ ! -s err.txt ] || fail "said $(cat err.txt)"
  # Of another scene, or damaged: it begins anew, and says so.
  expect 0 compare builtin:cube_g0 --methods fld -o kept --size 24x16 --reference-spp 8 -D 'media[0].g=0.5' --progress none
  said err.txt 'warning: the stored reference is not used: the state is of scene'
  said kept/errors.json '"spp": 8,'
  said kept/errors.json 'media\[0\]\.g=0\.5'
  printf 'x' >> kept/reference.exr.state
  expect 0 compare builtin:cube_g0 --methods fld -o kept --size 24x16 --reference-spp 8 -D 'media[0].g=0.5' --progress none
  said err.txt 'warning: the stored reference is not used: the state is cut short or damaged'
  # Noise that is known of finished images.
  expect 0 compare once.exr kept/fld.exr -o of_images
  said of_images/errors.json '"relative_noise": \{'
}

# Methods that are not made for the scene are left out, with the reason.
test_left_out() {
  expect 0 compare builtin:cloud_sun -o out --size 12x8 --spp 1 --reference-spp 4 --progress none
  said err.txt '^tyndall: screen is left out: media\[0\] \(cloud\) is not homogeneous'
  for name in path fld cda pop lpv dom octaves; do present "out/$name.exr"; done
  absent out/screen.exr
  said out/errors.json '"name": "screen",$'
  said out/errors.json '"reason": "media\[0\] \(cloud\) is not homogeneous'
  said out/table.md '^- screen: media\[0\] \(cloud\) is not homogeneous'
  for name in paths solve march; do said out/errors.json "\"name\": \"$name\"" ; done
  page out/report.html 8
  expect 0 compare builtin:cloud_sun --methods path,screen -o out --size 12x8 --spp 1 --reference-spp 4 -q
  [ ! -s err.txt ] || fail "said $(cat err.txt)"
}

# Fog all around the camera, in a room that glows; $1: more keys of the medium, $2: of the scene.
room() {
  cat << END
{ "tyndall": 1, "camera": { "position": [0, 0, 2], "target": [0, 0, 0], "resolution": [40, 30] },
  "media": [{ "bounds": [[-3, -3, -3], [3, 3, 3]], $1 }],
  "geometry": [{ "quad": { "origin": [-2, -2, -2], "u": [4, 0, 0], "v": [0, 4, 0] },
                 "material": { "albedo": 0, "emission": [1, 2, 3] } }] ${2:-} }
END
}

test_screen() {
  room '"sigma_a": 0.3' > dark.json
  expect 0 compare dark.json --methods screen,path -o dark --spp 64 --reference-spp 256 --stats stats.json
  said out.txt '^screen +(1\.00|0\.99)'
  said dark/errors.json '"own_seconds": '
  # What screen needs of the camera is in the images.
  for image in dark/reference.exr dark/screen.exr; do
    expect 0 info $image
    said out.txt '^tyndall\.camera\.fov_y [0-9]'
  done
  page dark/report.html 3
  # Without media both see the surfaces.
  room '"sigma_s": 0' > clear.json
  expect 0 render clear.json --method path -o path.exr --spp 8 -q
  expect 0 render clear.json --method screen -o screen.exr --spp 8 -q --stats stats.json
  same path.exr screen.exr
  said stats.json '"method": "screen"'
  said stats.json '"levels": '
  # What the scene asks for.
  room '"sigma_s": 0.5, "g": 0.9' ', "render": { "method": "screen", "spp": 4, "screen": { "variant": "naive", "filter": 6 } }' \
    > asked.json
  expect 0 render asked.json -o asked.exr --aov depth,normal
  said out.txt '^screen: 40x30, 4 spp'
  expect 0 info asked.exr
  said out.txt 'depth\.Z'
  unsaid out.txt 'samples\.N'
  expect 0 render asked.json -o ours.exr -D render.screen.variant=scatter -q
  expect 0 diff ours.exr asked.exr
  unsaid out.txt '^values that differ: 0$'
  expect 0 render asked.json -o wide.exr -D render.screen.variant=scatter -D render.screen.spread=gaussian -q
  expect 0 diff ours.exr wide.exr
  unsaid out.txt '^values that differ: 0$'
}

test_screen_refusals() {
  expect 2 compare builtin:cloud_sun --methods screen -o x --progress none
  said err.txt '^tyndall: builtin:cloud_sun: no method applies; screen: media\[0\] \(cloud\) is not homogeneous'
  usage_error 'media\[0\] \(cloud\) is not homogeneous' render builtin:cloud_sun --method screen -o x.exr
  usage_error "the method screen has no 'transmittance'" render dark.json --method screen --aov all -o x.exr
  usage_error '--crop: the method screen renders whole frames' render dark.json --method screen --crop 0,0,9x9 -o x.exr
  usage_error 'render.screen.filter: 5' render dark.json -D render.screen.filter=5 -o x.exr
  usage_error 'did you mean "scatter"' render dark.json -D render.screen.variant=scater -o x.exr
  absent x
  absent x.exr
  room '"sigma_s": 0.5, "sigma_a": 0.1, "emission": { "radiance": 1 }' > glowing.json
  expect 0 render glowing.json --method screen -o x.exr --size 8x6 --spp 1 --progress none
  said err.txt 'warning: .*the light that media\[0\] itself sends is left out'
  expect 0 render builtin:cornell_fog --method screen -o x.exr --size 8x8 --spp 1 --progress none
  said err.txt 'warning: .*the camera is outside a medium'
}

test_refusals() {
  usage_error "unknown method 'fog'; known: path, screen" compare builtin:cube_g0 --methods path,fog -o x
  usage_error '--reference-time is for rendering a reference' compare builtin:cube_g0 --reference new/path.exr --reference-time 9 -o x
  usage_error '-o DIR' compare builtin:cube_g0 --methods path
  usage_error 'one argument too many' compare builtin:cube_g0 new/path.exr --methods path -o x
  usage_error 'what to compare with' compare new/path.exr -o x
  usage_error 'only --exposure goes with finished images' compare new/path.exr new/path.exr --spp 3 -o x
  usage_error '--reference-spp' compare builtin:cube_g0 --methods path --reference new/path.exr --reference-spp 9 -o x
  usage_error 'a/b' compare builtin:cube_g0 --methods path -o a/b
  touch plain
  usage_error 'plain' compare builtin:cube_g0 --methods path -o plain
  absent x
  expect 0 render builtin:cube_g0 -o small.exr --size 8x8 --spp 1 -q
  usage_error 'small.exr and new/path.exr' compare new/path.exr small.exr -o x
  usage_error 'missing.exr' compare builtin:cube_g0 --methods path --reference missing.exr -o x
  usage_error 'cube_g7' compare builtin:cube_g7 --methods path -o x
  absent x
}

test_interrupt() {
  start compare builtin:cornell_fog --methods path -o cut --size 64x48 --spp 100000
  kill -INT "$process"
  finished 130
  absent cut/errors.json
  # The reference stays as far as it is, and the next run goes on from there.
  start compare builtin:cube_g0 --methods fld -o cut --size 24x16 --spp 1 --reference-noise 0.001
  for _ in $(seq 200); do
    grep -q '"stage": "reference"' err.txt && break
    sleep 0.1
  done
  sleep 0.3
  kill -INT "$process"
  finished 130
  said err.txt 'interrupted; the same command goes on from the reference'
  absent cut/errors.json
  present cut/reference.exr.state
  expect 0 info cut/reference.exr
  said out.txt '^tyndall.complete 0$'
  expect 0 compare builtin:cube_g0 --methods fld -o cut --size 24x16 --spp 1 --reference-time 0.001 --progress none
  said cut/errors.json '"stored": true'
  # So many samples more end what was cut short, too.
  expect 0 compare builtin:cube_g0 --methods fld -o cut --size 24x16 --spp 1 --reference-noise 0.001 --reference-time 0.2 \
    --progress none
  said cut/errors.json '"relative_noise"'
}

test_scene
test_images
test_page
test_reference
test_left_out
test_screen
test_screen_refusals
test_refusals
test_interrupt
no_temporary_files
finish 200

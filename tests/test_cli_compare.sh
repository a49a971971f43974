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
  said new/table.md '^\| path-2 \| all \| [01]\.?[0-9]* \|'
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
  said out.txt '^reference-2 +1 +0 +0 +0$'
  present images/heat_odd_name.png
  said images/table.md '^\| reference-2 \| G \| 1 \| 0 \| 0 \| 0 \| 64 \|'
  # As `tyndall diff` says.
  expect 0 diff new/path.exr new/reference.exr --json
  rmse=$(grep -m 1 '"rmse"' out.txt | tr -d ' ,')
  checks=$((checks + 1))
  tr -d ' ,' < images/errors.json | grep -qF "$rmse" || fail "diff says $rmse, compare does not"
}

# page FILE IMAGES: a page whose elements all close, that needs nothing from elsewhere, with so many images inside.
page() {
  said "$1" '^</html>$'
  unsaid "$1" '(src|href)="?(http|/|[a-z_]+\.)|url\(|@import'
  checks=$((checks + 1))
  [ "$(grep -o 'src="data:image/png;base64,iVBOR' "$1" | wc -l)" -eq "$2" ] || fail "$1 has not $2 images"
  command -v python3 > /dev/null || return 0
  checks=$((checks + 1))
  python3 - "$1" > page.txt 2>&1 << 'END' || fail "$1: $(tail -n 1 page.txt)"
import base64, html.parser, re, sys
class Page(html.parser.HTMLParser):
    empty = {"meta", "img", "input"}
    def __init__(self):
        super().__init__()
        self.open, self.names, self.wanted = [], set(), set()
    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag not in self.empty: self.open.append(tag)
        if "id" in values: self.names.add(values["id"])
        if values.get("type") == "radio": self.wanted.add(values["value"])
        if tag == "img": assert base64.b64decode(values["src"].split(",")[1], validate=True)[-8:-4] == b"IEND"
        if tag == "img": assert values["alt"]
    def handle_endtag(self, tag):
        assert self.open.pop() == tag, tag
text = open(sys.argv[1], encoding="utf-8").read()
page = Page()
page.feed(text)
page.close()
assert not page.open, page.open
assert page.wanted and page.wanted <= page.names, page.wanted
END
}

test_page() {
  page new/report.html 3
  said new/report.html '^<h1>builtin:cube_g0</h1>$'
  said new/report.html 'Reference: new/reference.exr, 64 samples per pixel'
  said new/report.html '<td>path</td><td>all</td><td>[01]\.?[0-9]*</td>'
  page images/report.html 7
  # A name that is markup stays text.
  odd='a<b onload=x>"&'\''.exr'
  cp new/path.exr "$odd"
  expect 0 compare "$odd" new/path.exr -o odd -q
  said odd/report.html 'Reference: a&lt;b onload=x&gt;&quot;&amp;&#39;\.exr, 4 samples'
  page odd/report.html 3
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
  page dark/report.html 5
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
  usage_error 'media\[0\] \(cloud\) is not homogeneous' compare builtin:cloud_sun --methods path,screen -o x
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
  usage_error 'which methods' compare builtin:cube_g0 -o x
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
}

test_scene
test_images
test_page
test_screen
test_screen_refusals
test_refusals
test_interrupt
no_temporary_files
finish 130

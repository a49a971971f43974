#!/usr/bin/env bash
# tyndall convert on scenes of pbrt and Mitsuba, from outside: the scenes of tests/interchange against the same scenes
# by hand, files and grids, what is left out, messages.
# usage: test_interchange.sh TYNDALL DATA (works in the current folder, which it empties)
. "$(dirname "$0")/cli.sh"
scenes=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/interchange

# same_pixels A.json B.json: their images are equal, to the last bit.
same_pixels() {
  expect 0 render "$1" -o a.exr -q
  expect 0 render "$2" -o b.exr -q
  expect 0 diff a.exr b.exr
  said out.txt '^values that differ: 0$'
}

# close_pixels A.json B.json RMSE: relative, of images whose positions differ by rounding alone.
close_pixels() {
  expect 0 render "$1" -o a.exr -q
  expect 0 render "$2" -o b.exr -q
  expect 0 diff a.exr b.exr
  checks=$((checks + 1))
  awk -v most="$3" '$1 == "all" { found = 1; exit !($4 < most && $2 > 0.999 && $2 < 1.001) } END { if (!found) exit 1 }' \
    out.txt || fail "the images differ: $(grep '^all' out.txt)"
}

test_pbrt_is_the_same_scene() {
  expect 0 convert "$scenes/room.pbrt" room.json
  unsaid out.txt '^- '
  same_pixels room.json "$scenes/room_pbrt.json"
}

test_mitsuba_is_the_same_scene() {
  expect 0 convert "$scenes/room.xml" room.json
  unsaid out.txt '^- '
  same_pixels room.json "$scenes/room_mitsuba.json"
}

camera='"camera": { "position": [0, 0, 4], "target": [0, 0, 3], "up": [0, 1, 0], "fov_y": 30, "resolution": [16, 16] }'
sky='"lights": [{ "type": "environment", "radiance": [0.5, 0.75, 1] }]'
head='Scale 1 1 -1 Translate 0 0 -4 Camera "perspective" "float fov" 30
  Film "rgb" "integer xresolution" 16 "integer yresolution" 16 Sampler "halton" "integer pixelsamples" 16
  Integrator "volpath" "integer maxdepth" 20 WorldBegin LightSource "infinite" "rgb L" [.5 .75 1]'
path='"render": { "method": "path", "spp": 16, "path": { "max_depth": 20 } }'

# Values at the centres of eight voxels, which fade to 0 half a voxel beyond the outer ones, cut by p0 and p1.
test_pbrt_grid() {
  cat > grid.pbrt << END
$head
MakeNamedMedium "smoke" "string type" "uniformgrid" "integer nx" 2 "integer ny" 2 "integer nz" 2
  "float density" [1 2 3 4 5 6 7 8] "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1] "rgb sigma_s" [.5 .5 .5]
  "rgb sigma_a" [.25 .25 .25] "float g" 0.25
AttributeBegin
MediumInterface "smoke" "" Material "interface" Shape "sphere" "float radius" 2
AttributeEnd
END
  printf '\1\2\3\4\5\6\7\10' > grid.raw
  cat > hand.json << END
{ "tyndall": 1, $camera, $sky, $path,
  "media": [{ "density": { "file": "grid.raw", "raw": { "size": [2, 2, 2], "spacing": 1 } }, "sigma_s": 0.5, "sigma_a": 0.25,
    "g": 0.25, "bounds": [[-0.5, -0.5, -0.5], [1.5, 1.5, 1.5]], "transform": { "translate": [-0.5, -0.5, -0.5] } }] }
END
  expect 0 convert grid.pbrt grid.json
  present grid_files/volume_1.vdb
  same_pixels grid.json hand.json
}

# Grids of coefficients: a grey one is one medium, and coloured ones are media for each channel, which add up.
test_pbrt_rgb_grid() {
  grey="" coloured=""
  for v in 1 2 3 4 5 6 7 8; do grey="$grey $v $v $v" coloured="$coloured $v $v $((2 * v))"; done
  for kind in grey coloured; do
    cat > $kind.pbrt << END
$head
MakeNamedMedium "smoke" "string type" "rgbgrid" "integer nx" 2 "integer ny" 2 "integer nz" 2 "float g" 0.25
  "rgb sigma_s" [${!kind}] "rgb sigma_a" [${grey}] "float scale" 0.25 "point3 p0" [-1 -1 -1] "point3 p1" [1 1 1]
AttributeBegin
MediumInterface "smoke" "" Material "interface" Shape "sphere" "float radius" 2
AttributeEnd
END
    expect 0 convert $kind.pbrt $kind.json
    expect 0 render $kind.json -o $kind.exr -q --spp 256
  done
  sed 's/"sigma_s": 0.5/"sigma_s": 0.25/' hand.json > hand_grey.json
  sed 's/"sigma_s": 0.5/"sigma_s": [0.25, 0.25, 0.5]/' hand.json > hand_coloured.json
  for kind in grey coloured; do
    expect 0 render hand_$kind.json -o hand.exr -q --spp 256
    expect 0 diff $kind.exr hand.exr
    checks=$((checks + 1))
    # Of media that add up other random numbers are used.
    awk '$1 ~ /^(R|G|B|all)$/ && ($2 < 0.99 || $2 > 1.01) { bad = 1 } END { exit bad }' out.txt ||
      fail "the means differ: $(cat out.txt)"
  done
}

# Mitsuba clamps a grid at the faces of its cube, as a raw volume that fills a box is clamped here; the shape cuts it.
test_mitsuba_grid() {
  { printf 'VOL\3\1\0\0\0\2\0\0\0\1\0\0\0\1\0\0\0\1\0\0\0'
    printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\200\77\0\0\200\77'
    printf '\0\0\200\77\0\0\100\100'; } > two.vol # 1 and 3
  cat > grid.xml << 'END'
<scene version="3.0.0">
  <integrator type="volpath"><integer name="max_depth" value="21"/></integrator>
  <sensor type="perspective"><float name="fov" value="30"/>
    <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler></sensor>
  <emitter type="constant"><rgb name="radiance" value="0.5 0.75 1"/></emitter>
  <medium type="heterogeneous" id="smoke">
    <volume type="gridvolume" name="sigma_t"><string name="filename" value="two.vol"/>
      <transform name="to_world"><translate x="-.5" y="-.5" z="-.5"/><scale value="2"/></transform></volume>
    <float name="albedo" value="0.5"/><float name="scale" value="0.5"/>
  </medium>
  <shape type="cube"><transform name="to_world"><scale x="2" y="2" z="0.5"/></transform><bsdf type="null"/>
    <ref name="interior" id="smoke"/></shape>
</scene>
END
  printf '\1\3' > two.raw
  cat > hand_two.json << END
{ "tyndall": 1, $camera, $sky, $path,
  "media": [{ "density": { "file": "two.raw", "raw": { "size": [2, 1, 1] } }, "sigma_s": 0.25, "sigma_a": 0.25,
    "bounds": [[-1, -1, -0.5], [1, 1, 0.5]] }] }
END
  expect 0 convert grid.xml two.json
  close_pixels two.json hand_two.json 0.06 # measured .038, by paths that rounding turns aside; .0048 at 1024 spp
}

# A mesh from a compressed PLY file, its instances, a texture that is referred to, and includes.
test_pbrt_files() {
  mkdir -p in out
  printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' |
    gzip > in/triangle.ply.gz
  cat > in/objects.pbrt << 'END'
ObjectBegin "three" Material "diffuse" Shape "plymesh" "string filename" "triangle.ply.gz" ObjectEnd
END
  cat > in/files.pbrt << END
$head
Include "objects.pbrt"
ObjectInstance "three"
Translate 1 0 0
ObjectInstance "three"
END
  expect 0 convert in/files.pbrt out/files.json
  expect 0 info out/files.json
  said out.txt '^meshes +2, 2 triangles$'
  rm in/objects.pbrt
  usage_error 'in/files.pbrt:4: the file "objects.pbrt" cannot be read: No such file' convert in/files.pbrt out/files.json
  expect 0 convert in/files.pbrt out/files.json --partial
  said out.txt '^- left out: the object "three", which is not defined \(2 times\)$'
}

# A lamp behind a ball of rough glass: Mitsuba's Beckmann microfacets as GGX of the same median slope. The mean is that of a
# program of its own that traces this ball, 0.8123 with a standard error of 0.0005 (0.948 with Beckmann's microfacets, 0.607 with
# GGX of Beckmann's alpha). Measured: 0.2 % from it, with a noise of 0.7 %.
test_rough_glass() {
  local glass='<bsdf type="roughdielectric"><float name="alpha" value="0.3"/><float name="int_ior" value="1.29964"/>
    <float name="ext_ior" value="1"/></bsdf>'
  cat > glass.xml << END
<scene version="3.0.0">
  <integrator type="volpath"><integer name="max_depth" value="13"/></integrator>
  <sensor type="perspective"><float name="fov" value="34.02205717"/>
    <transform name="to_world"><lookat origin="0,0.5,4" target="0,-0.5,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/></film>
    <sampler type="independent"><integer name="sample_count" value="256"/></sampler></sensor>
  <emitter type="spot"><rgb name="intensity" value="1"/><float name="cutoff_angle" value="60"/>
    <transform name="to_world"><lookat origin="0,-0.5,-2" target="0,0.5,0" up="0,1,0"/></transform></emitter>
  <shape type="sphere"><point name="center" x="0" y="-0.104338" z="0"/><float name="radius" value="0.757253"/>$glass</shape>
</scene>
END
  expect 0 convert glass.xml glass.json
  said out.txt 'that of GGX with the same median slope$'
  expect 0 render glass.json -o glass.exr -D render.path.energy_compensation=false
  expect 0 info glass.exr
  checks=$((checks + 1))
  awk '$1 == "G" { exit !($3 > 0.79 && $3 < 0.835) }' out.txt || fail "the ball of glass: $(grep '^G' out.txt)"
}

# Each dielectric with a medium is a file of its own, which bounds both.
test_filled_glass() {
  local cube='<bsdf type="dielectric"/><ref name="interior" id="milk"/>'
  cat > one.xml << END
<scene version="3.0.0"><medium id="milk" type="homogeneous"/><emitter type="constant"/>
  <shape type="cube">$cube</shape><shape type="cube"><transform name="to_world"><translate x="3"/></transform>$cube</shape>
</scene>
END
  expect 0 convert one.xml one.json
  checks=$((checks + 1))
  [ "$(grep -c '"file": "one_files/mesh_' one.json)" -eq 4 ] || fail "one.json has not a file for each cube and its medium"
}

# What is left out is printed, and stands in the file.
test_notes() {
  printf '%s Shape "curve" "point3 P" [0 0 0 1 0 0 2 0 0 3 0 0]\nShape "sphere" "float wings" 2' "$head" > notes.pbrt
  expect 0 convert notes.pbrt notes.json
  said out.txt '^left out or approximated:$'
  said out.txt '^- left out: Shape "curve"$'
  said out.txt '^- left out: Shape "sphere": the parameter "wings"$'
  said notes.json '"left out: Shape ."?curve'
  expect 0 info notes.json
}

test_messages() {
  while IFS='|' read -r text pattern; do
    printf '%s\n%s\n' "$head" "$text" > bad.pbrt
    usage_error "bad.pbrt:4: $pattern" convert bad.pbrt bad.json
    absent bad.json
  done << 'END'
Shape "pyramid"|the shape "pyramid" is not known
Shape "sphere" "float radius" "big"|"big" is not a value of the parameter "radius"
Shape "sphere" "float radius" -1|the radius of the sphere, -1, is not above 0
Shape "trianglemesh" "point3 P" [0 0 0 1 0 0 0 1 0] "integer indices" [0 1 7]|the index 7 is not that of a vertex
Shape "trianglemesh" "point3 P" [0 0 0 1 0|the values of the parameter "P" do not end
Material "paper"|the material "paper" is not known
NamedMaterial "gold"|the material "gold" is not defined
MediumInterface "fog" ""|the medium "fog" is not defined
LightSource "point" "length I" 3|the type "length" of the parameter "I" is not known
Colour 1 2 3|the directive "Colour" is not known
AttributeEnd|an end has no begin
Film "rgb"|Film stands after WorldBegin
Include "absent.pbrt"|the file "absent.pbrt" cannot be read
END
  while IFS='|' read -r text pattern; do
    printf '<scene version="3.0.0">\n%s\n</scene>\n' "$text" > bad.xml
    usage_error "bad.xml:$pattern" convert bad.xml bad.json
  done << 'END'
<shape type="sphere"><float name="radius" value="big"/></shape>|2: "big" is not what should stand here in numbers
<shape type="obj"><string name="filename" value="absent.obj"/></shape>|2: the file "absent.obj" cannot be read
<integrator type="path"><integer name="max_depth" value="$depth"/></integrator>|2: the parameter "\$depth" has no default
<shape type="sphere">|3: not XML: mismatched tag
END
  usage_error 'a scene goes to .json' convert "$scenes/room.pbrt" room.exr
  usage_error 'cannot be read' convert absent.pbrt room.json
}

for name in $(declare -F | sed -n 's/^declare -f \(test_\)/\1/p'); do $name; done
no_temporary_files
finish 60

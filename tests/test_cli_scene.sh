#!/usr/bin/env bash
# tyndall info of scenes that name files, of meshes and of images, from outside.
# usage: test_cli_scene.sh TYNDALL (empties the current folder)
. "$(dirname "$0")/cli.sh"

write_files() {
  printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\n' > tetra.obj
  printf '\001\002' > heat_07.raw
  cat > camera.gltf << 'END'
{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
 "cameras": [{"type": "perspective", "name": "front", "perspective": {"yfov": 1, "znear": 0.1}}]}
END
  cat > scene.json << 'END'
{"tyndall": 1, "frame": 7,
 "media": [
   {"name": "milk", "sigma_s": 1, "bounds": {"file": "tetra.obj"}},
   {"name": "fire", "sigma_t": 1, "bounds": [[0, 0, 0], [1, 1, 1]], "density": {"noise": {"resolution": 4}},
    "transfer": [{"value": 0, "density": 0, "albedo": 0.5}, {"value": 1, "density": 2, "albedo": 0.5}],
    "emission": {"temperature": {"file": "heat_##.raw", "raw": {"size": [2, 1, 1]}}, "kelvin": [300, 1500]}}],
 "geometry": [{"file": "camera.gltf"}, {"file": "tetra.obj", "material": {"emission": 1}}]}
END
}

test_text() {
  expect 0 info scene.json
  said out.txt '^camera .*57.2958 degrees high, exposure 0, the first of camera.gltf$'
  said out.txt '^            within a closed mesh$'
  said out.txt '^            box \(0, 0, 0\) to \(1, 1, 1\) m$'
  said out.txt '^            density 4x4x4 half, filling the box, '
  said out.txt '^            transfer function of 2 points, 0 to 1, with albedo$'
  said out.txt '^            emission: radiance 0 W m\^-2 sr\^-1, black body of 300 K at 0 to 1500 K at 1, scale 1$'
  said out.txt '^            temperature 2x1x1 half, filling the box, 1 to 2, '
  said out.txt '^meshes      1, 4 triangles$'
  said out.txt '^emitters    4$'
  expect 0 info scene.json -D camera.file=camera.gltf -D camera.name=front
  said out.txt ', "front" of camera.gltf$'
  usage_error 'cannot open \./heat_08.raw|cannot open heat_08.raw' info scene.json -D frame=8
}

test_json() {
  expect 0 info scene.json --json
  valid_json out.txt
  said out.txt '"source": "the first of camera.gltf"'
  said out.txt '"bounds": "closed mesh"'
  said out.txt '"kelvin": \[300, 1500\]'
  said out.txt '"triangles": 4'
  said out.txt '"emitters": 4'
  said out.txt '"albedo": \[0.5, 0.5, 0.5\]'
}

# Memory and messages of a large grid that is divided among ranks.
test_plan() {
  large='-D render.dom.resolution=1024 -D render.fld.resolution=1024 -D render.fld.ratio=1'
  expect 0 info builtin:cube_g0.7 --ranks 1024 $large --json
  valid_json out.txt
  said out.txt '"cells_of_a_rank": \[32, 32, 1024\]'
  said out.txt '"units": 488'
  said out.txt '"stages": 548'
  said out.txt '"stages_corner_by_corner": 736'
  said out.txt '"ranks_along_x_y_z": \[1, 32, 32\]'
  said out.txt '"divided_levels": 4'
  expect 0 info builtin:cube_g0.7 --ranks 16384
  said out.txt '^  refused: "ordinates: there are too few cells for 16384 ranks"$'
  said out.txt '^  refused: "diffusion: 32 x 32 x 32 cells are too few for 16384 ranks"$'
  usage_error '--ranks is for scenes' info tetra.obj --ranks 4
  usage_error 'there are no media to divide' info scene.json --ranks 4 -D 'media=[]'
}

test_meshes() {
  printf 'newmtl red\nKd 1 0 0\nnewmtl lamp\nKe 5 5 5\n' > two.mtl
  { echo 'mtllib two.mtl'; cat tetra.obj; echo 'usemtl lamp'; echo 'f 1 2 3'; } > two.obj
  expect 0 info two.obj
  said out.txt '^meshes +2, 5 triangles$'
  said out.txt '^materials +2$'
  said out.txt '^ +lamp: diffuse, base_color \(0.5, 0.5, 0.5\), emission \(5, 5, 5\)$'
  said out.txt '^emitters +1$'
  said out.txt '^bounds +\(0, 0, 0\) to \(1, 1, 1\)$'
  said out.txt '^memory +[0-9.]+ KiB$'
  expect 0 info camera.gltf
  said out.txt '^meshes +0, 0 triangles$'
  said out.txt '^cameras +1$'
  said out.txt '^ +front, 57.2958 degrees high$'
  unsaid out.txt '^bounds'
  expect 0 info camera.gltf --json
  valid_json out.txt
  said out.txt '"kind": "mesh"'
  said out.txt '"name": "front"'
  said out.txt '"orthographic": false'
  expect 0 info two.obj --json
  valid_json out.txt
  said out.txt '"name": "red"'
  said out.txt '"base_color": \[1, 0, 0\]'
  said out.txt '"glossy": false'
  said out.txt '"triangles": 5'
  printf 'newmtl glass\nillum 7\nNi 1.33\nTf 1 0.5 0.25\nnewmtl gold\nPm 1\nPr 0.3\nKd 1 0.8 0.3\nd 0.5\nPc 1\nPs 0.1\n' > more.mtl
  { echo 'mtllib more.mtl'; cat tetra.obj; } > more.obj
  expect 0 info more.obj
  said out.txt '^ +glass: solid dielectric, base_color \(1, 0.5, 0.25\), metallic 0, roughness 0, ior 1.33, transmission 1$'
  said out.txt '^ +gold: glossy, .*metallic 1, roughness 0.3, clearcoat 1, sheen_roughness 0.5, alpha blend 0.5$'
  cat > textured.gltf << 'END'
{"asset": {"version": "2.0"}, "images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGNoaGgAAAMEAYFL09IQAAAAAElFTkSuQmCC"}],
 "textures": [{"source": 0}],
 "materials": [{"name": "wall", "normalTexture": {"index": 0}, "pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}]}
END
  expect 0 info textured.gltf
  said out.txt '^ +wall: glossy, .*, textures: metallic and roughness, normal_map$'
  expect 0 info textured.gltf --json
  valid_json out.txt
  printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n' > one.ply
  printf 'element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >> one.ply
  expect 0 info one.ply
  said out.txt '^meshes +1, 1 triangles$'
  said out.txt '^materials +0$'
  usage_error '-D is for scenes' info one.ply -D frame=8
}

test_pictures() {
  expect 0 render builtin:cube_g0 -o one.png --size 16x12 --spp 1 -q
  expect 0 info one.png
  said out.txt '^size +16x12$'
  said out.txt '^R +0 '
  expect 0 diff one.png one.png
  said out.txt '^values that differ: 0$'
  cp "$(dirname "$0")/fuzz/corpus/jpeg/ycc.jpg" ycc.jpg
  expect 0 info ycc.jpg --json
  valid_json out.txt
  said out.txt '"kind": "image"'
  expect 0 diff ycc.jpg ycc.jpg --json
  said out.txt '"differing": 0,'
}

write_files
test_text
test_json
test_plan
test_meshes
test_pictures
finish 60

#!/usr/bin/env bash
# --denoiser oidn by stand-ins for the library, with the names of version 1 and of version 2, and without one.
# usage: test_oidn.sh TYNDALL FOLDER_1 FOLDER_2 (empties the current folder)
folders="$2 $3"
. "$(dirname "$0")/cli.sh"

# Without the library: a machine where it is installed has nothing to say here.
usage_error_without_library() {
  (LD_LIBRARY_PATH=; ldconfig -p > ldconfig.txt 2>&1)
  grep -q libOpenImageDenoise ldconfig.txt && return
  usage_error 'Open Image Denoise is not installed' render builtin:cube_g0 --method path -o x.exr --size 8x8 --spp 4 --denoise --denoiser oidn
  absent x.exr
  usage_error 'Open Image Denoise is not installed' denoise missing.exr -o x.exr --denoiser oidn
}

test_refusals() {
  usage_error 'give both' render builtin:cube_g0 --method path -o x.exr --denoiser oidn
  usage_error 'regression' denoise noisy.exr -o x.exr --denoiser other
}

test_library() {
  export LD_LIBRARY_PATH=$1
  expect 0 denoise noisy.exr -o d.exr --denoiser oidn --stats d.json
  said out.txt '^denoised: relative error .*, 6 features, '
  said d.json '"parts": 1'
  expect 0 denoise bare.exr -o bare_d.exr --denoiser oidn
  said out.txt '^denoised: relative error .*, 0 features, '
  expect 0 render builtin:cornell_fog --method path -o r.exr --size 32x24 --spp 8 --seed 3 -q --denoise --denoiser oidn
  expect 0 convert d.exr a.exr --layer denoised
  expect 0 convert r.exr b.exr --layer denoised
  expect 0 diff a.exr b.exr
  said out.txt 'values that differ: 0'
  # The mean of all light stays, and single pixels do not.
  expect 0 diff a.exr noisy.exr --block 24 --json
  said out.txt '"mean_ratio": (1\.0[0-4]|0\.9[6-9])'
  expect 0 diff a.exr noisy.exr
  unsaid out.txt 'values that differ: 0'
  FAKE_OIDN_FAILS=1 expect 1 denoise noisy.exr -o f.exr --denoiser oidn
  said err.txt 'Open Image Denoise: failure on demand'
  absent f.exr
  unset LD_LIBRARY_PATH
}

expect 0 render builtin:cornell_fog --method path -o noisy.exr --size 32x24 --spp 8 --seed 3 -q --aov all,half
expect 0 render builtin:cornell_fog --method path -o bare.exr --size 32x24 --spp 8 --seed 3 -q --aov half
usage_error_without_library
test_refusals
for folder in $folders; do test_library "$folder"; done
no_temporary_files
finish 20

# cmake -DCLANG=clang -DSOURCE=NAME_program.c -DINCLUDE=folders -DOUTPUT=NAME.ptx -P ptx.cmake
# Compiles to LLVM's language, marks the entry points as kernels, for which clang 14 has no attribute in C, and compiles that
# to PTX. Version 6.0 for sm_60 is what all drivers since CUDA 9.0 take for all GPUs since 2016. Denormals count as 0, as on
# the processor (base/float_mode.h). Loops are not unrolled: such programs are so large that a GPU waits for instructions most
# of the time.
set(target --target=nvptx64-nvidia-cuda -march=sm_60 -Xclang -target-feature -Xclang +ptx60)
list(GET INCLUDE 0 source_folder)
list(TRANSFORM INCLUDE PREPEND "-I")
get_filename_component(folder "${OUTPUT}" DIRECTORY)
file(MAKE_DIRECTORY "${folder}")

execute_process(
  COMMAND "${CLANG}" ${target} --cuda-path=/nonexistent -Wno-unused-command-line-argument -std=c17 -ffreestanding -nostdlibinc
    "-I${source_folder}/device/freestanding" ${INCLUDE} -DTY_DEVICE=1 -O3 -fno-unroll-loops -fno-math-errno -fno-trapping-math
    -ffp-contract=off -Xclang -fdenormal-fp-math-f32=preserve-sign,preserve-sign -MD -MF "${OUTPUT}.d" -MT "${OUTPUT}"
    -S -emit-llvm "${SOURCE}" -o "${OUTPUT}.ll"
  COMMAND_ERROR_IS_FATAL ANY)
file(READ "${OUTPUT}.ll" text)
string(REGEX REPLACE "define (dso_local )?void @ty_entry_" "define \\1ptx_kernel void @ty_entry_" text "${text}")
file(WRITE "${OUTPUT}.ll" "${text}")
execute_process(COMMAND "${CLANG}" ${target} --cuda-path=/nonexistent -Wno-unused-command-line-argument -O3 -S "${OUTPUT}.ll"
  -o "${OUTPUT}" COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE "${OUTPUT}.ll")

# tyndall_options: what every target of ours is compiled with.
add_library(tyndall_options INTERFACE)
target_compile_options(tyndall_options INTERFACE
  -Wall -Wextra -Wshadow -Wvla
  $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes -Wmissing-prototypes>
  -fno-math-errno -fno-trapping-math -ffp-contract=fast -fopenmp-simd)
# Sanitizers and builds for debugging keep clang from vectorising loops that are marked for it, which it warns of.
if(CMAKE_C_COMPILER_ID MATCHES Clang)
  target_compile_options(tyndall_options INTERFACE -Wno-pass-failed)
endif()
if(TYNDALL_WERROR)
  target_compile_options(tyndall_options INTERFACE -Werror)
endif()

# Fuzz builds instrument the library for libFuzzer; only the fuzz targets link its main.
set(tyndall_sanitizers "${TYNDALL_SANITIZE}")
if(TYNDALL_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "TYNDALL_FUZZ needs clang: -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++")
  endif()
  set(tyndall_sanitizers "address,undefined")
  target_compile_options(tyndall_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(tyndall_sanitizers)
  target_compile_options(tyndall_options INTERFACE
    -fsanitize=${tyndall_sanitizers} -fno-omit-frame-pointer -fno-sanitize-recover=all
    $<$<COMPILE_LANG_AND_ID:C,GNU>:-Wno-maybe-uninitialized>) # it guesses wrong between a sanitizer's calls
  target_link_options(tyndall_options INTERFACE -fsanitize=${tyndall_sanitizers})
  # A null or wrong pointer shows when the address sanitizer sees it used: checks of each pointer before that take a fifth
  # of the tests' time. The builds for fuzzing have them.
  if(NOT TYNDALL_FUZZ AND tyndall_sanitizers MATCHES "address")
    target_compile_options(tyndall_options INTERFACE -fno-sanitize=null,object-size,pointer-overflow)
  endif()
endif()

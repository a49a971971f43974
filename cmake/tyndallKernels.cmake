# tyndall_kernels(OBJECTS SOURCE): compiles a hot loop's file once per instruction set and appends the objects to the
# list OBJECTS, for the target that uses them. The file sees TY_ISA (v1, v3 or v4: the x86-64 microarchitecture levels)
# and exports its functions under names that end in it; every file sees TY_ISA_X86=1 where v3 and v4 exist, and the
# caller chooses among them with base/dispatch.h when the program runs.
include(CheckCSourceCompiles)
check_c_source_compiles("
#if !defined(__x86_64__)
#error other
#endif
int main(void) { return 0; }" TYNDALL_X86_64)

set(TYNDALL_KERNELS "all" CACHE STRING
  "all: kernels for every instruction set; native: for what this machine has best alone, for builds that stay here")
set_property(CACHE TYNDALL_KERNELS PROPERTY STRINGS all native)
set(tyndall_isas v1)
if(TYNDALL_X86_64 AND TYNDALL_KERNELS STREQUAL "native")
  # Asks the library's own code. Where there is one instruction set, it goes by the name of the first.
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/CMakeFiles/native_isa.c" @ONLY CONTENT "
#include \"base/isa.c\"
int main(void) { return (int)ty_best_isa(); }\n")
  try_run(TYNDALL_NATIVE_ISA TYNDALL_NATIVE_ISA_COMPILED "${PROJECT_BINARY_DIR}"
    "${PROJECT_BINARY_DIR}/CMakeFiles/native_isa.c"
    CMAKE_FLAGS "-DINCLUDE_DIRECTORIES=${PROJECT_SOURCE_DIR}/src" COMPILE_DEFINITIONS -DTY_ISA_X86=1)
  set(tyndall_native_isa x86-64 x86-64-v3 x86-64-v4)
  list(GET tyndall_native_isa "${TYNDALL_NATIVE_ISA}" tyndall_native_isa)
elseif(TYNDALL_X86_64)
  list(APPEND tyndall_isas v3 v4)
  target_compile_definitions(tyndall_options INTERFACE TY_ISA_X86=1)
endif()

function(tyndall_kernels objects source)
  string(MAKE_C_IDENTIFIER "${source}" stem)
  foreach(isa IN LISTS tyndall_isas)
    set(name "${stem}_${isa}")
    add_library(${name} OBJECT ${source})
    target_link_libraries(${name} PRIVATE tyndall_options)
    target_include_directories(${name} PRIVATE
      "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src" "${PROJECT_SOURCE_DIR}/tools")
    target_compile_definitions(${name} PRIVATE TY_ISA=${isa})
    if(NOT tyndall_sanitizers) # what those add, -O3 takes minutes to see through
      target_compile_options(${name} PRIVATE -O3)
    endif()
    if(NOT isa STREQUAL "v1")
      target_compile_options(${name} PRIVATE -march=x86-64-${isa})
    elseif(tyndall_native_isa)
      target_compile_options(${name} PRIVATE -march=${tyndall_native_isa})
    endif()
    list(APPEND ${objects} $<TARGET_OBJECTS:${name}>)
  endforeach()
  set(${objects} "${${objects}}" PARENT_SCOPE)
endfunction()

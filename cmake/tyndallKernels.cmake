# tyndall_kernels(OBJECTS SOURCE): compiles a hot loop's file once per instruction set and appends the objects to the
# list OBJECTS, for the target that uses them. The file sees TY_ISA (v1, v3 or v4: the x86-64 microarchitecture levels)
# and exports its functions under names that end in it; every file sees TY_ISA_X86=1 where v3 and v4 exist, and the
# caller chooses among them when the program runs.
include(CheckCSourceCompiles)
check_c_source_compiles("
#if !defined(__x86_64__)
#error other
#endif
int main(void) { return 0; }" TYNDALL_X86_64)
if(TYNDALL_X86_64)
  target_compile_definitions(tyndall_options INTERFACE TY_ISA_X86=1)
endif()

function(tyndall_kernels objects source)
  set(isas v1)
  if(TYNDALL_X86_64)
    list(APPEND isas v3 v4)
  endif()
  string(MAKE_C_IDENTIFIER "${source}" stem)
  foreach(isa IN LISTS isas)
    set(name "${stem}_${isa}")
    add_library(${name} OBJECT ${source})
    target_link_libraries(${name} PRIVATE tyndall_options)
    target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")
    target_compile_definitions(${name} PRIVATE TY_ISA=${isa})
    target_compile_options(${name} PRIVATE -O3)
    if(NOT isa STREQUAL "v1")
      target_compile_options(${name} PRIVATE -march=x86-64-${isa})
    endif()
    list(APPEND ${objects} $<TARGET_OBJECTS:${name}>)
  endforeach()
  set(${objects} "${${objects}}" PARENT_SCOPE)
endfunction()

# Programs for devices (docs/device.md). tyndall_device_programs(TARGET SOURCES...): each source NAME_program.c, with one
# TY_DEVICE_ENTRY(NAME, ...), is built for this machine into TARGET, and by clang into PTX that TARGET holds deflated as
# ty_ptx_NAME. Where there is no clang that makes PTX, that array is empty and device cuda says so.
set(TYNDALL_PTX ON CACHE BOOL "Build the programs for NVIDIA's GPUs, where there is a clang that can")
find_program(TYNDALL_PTX_CLANG NAMES clang clang-19 clang-18 clang-17 clang-16 clang-15 clang-14)
mark_as_advanced(TYNDALL_PTX_CLANG)
set(tyndall_ptx OFF)
if(TYNDALL_PTX AND TYNDALL_PTX_CLANG AND NOT tyndall_sanitizers)
  execute_process(COMMAND "${TYNDALL_PTX_CLANG}" --print-targets OUTPUT_VARIABLE targets ERROR_QUIET)
  if(targets MATCHES "nvptx64")
    set(tyndall_ptx ON)
  endif()
endif()
if(NOT tyndall_ptx)
  message(STATUS "No programs for NVIDIA's GPUs: they need a clang with the target nvptx64, and no sanitizers")
endif()

function(tyndall_device_programs target)
  add_executable(make_ptx_array device/make_ptx_array.c) # a program of the build
  target_compile_features(make_ptx_array PRIVATE c_std_17)
  target_link_libraries(make_ptx_array PRIVATE ZLIB::ZLIB)
  set_target_properties(make_ptx_array PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
  set(script "${PROJECT_SOURCE_DIR}/cmake/ptx.cmake")
  set(arrays "")
  foreach(source IN LISTS ARGN)
    get_filename_component(name "${source}" NAME)
    string(REGEX REPLACE "_program[.]c$" "" name "${name}")
    set(ptx "${CMAKE_CURRENT_BINARY_DIR}/ptx/${name}.ptx")
    set(array "${CMAKE_CURRENT_BINARY_DIR}/ptx/${name}.c")
    set(made "")
    if(tyndall_ptx)
      add_custom_command(OUTPUT "${ptx}"
        COMMAND "${CMAKE_COMMAND}" "-DCLANG=${TYNDALL_PTX_CLANG}" "-DSOURCE=${CMAKE_CURRENT_SOURCE_DIR}/${source}"
          "-DINCLUDE=${CMAKE_CURRENT_SOURCE_DIR};${PROJECT_SOURCE_DIR}/include" "-DOUTPUT=${ptx}" -P "${script}"
        DEPENDS "${source}" "${script}" DEPFILE "${ptx}.d" VERBATIM)
      set(made "${ptx}")
    endif()
    add_custom_command(OUTPUT "${array}" COMMAND make_ptx_array "${name}" "${array}" ${made}
      DEPENDS make_ptx_array ${made} VERBATIM)
    list(APPEND arrays "${array}")
  endforeach()
  # As on other devices: without a C library, and without a contraction of a product and a sum, so that results are the same
  # bit for bit.
  add_library(${target} OBJECT ${ARGN} ${arrays})
  target_compile_features(${target} PRIVATE c_std_17)
  target_compile_definitions(${target} PRIVATE TY_DEVICE=1)
  target_include_directories(${target} BEFORE PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/device/freestanding"
    "${CMAKE_CURRENT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/include")
  target_link_libraries(${target} PRIVATE tyndall_options)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -ffp-contract=off) # after those of tyndall_options
endfunction()

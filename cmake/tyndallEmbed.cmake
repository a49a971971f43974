# Files that live inside the library: each becomes a C file with its bytes as a char array, because string literals
# have a length limit. The C files are made again when a file changes, or one appears or goes.

# tyndall_embed_file(TARGET FILE NAME): const char NAME_text[], NUL-terminated, and const unsigned NAME_size.
function(tyndall_embed_file target file name)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.c")
  set(script "${PROJECT_SOURCE_DIR}/cmake/embed_file.cmake")
  get_filename_component(file "${file}" ABSOLUTE)
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DINPUT=${file}" "-DOUTPUT=${output}" "-DNAME=${name}" -P "${script}"
    DEPENDS "${file}" "${script}" VERBATIM)
  target_sources(${target} PRIVATE "${output}")
endfunction()

# tyndall_embed_scenes(TARGET FOLDER NAME): an array NAME[] of ty_builtin_scene (src/io/scenes/builtin.h) from the folder's
# *.json.
function(tyndall_embed_scenes target folder name)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.c")
  set(script "${PROJECT_SOURCE_DIR}/cmake/embed_scenes.cmake")
  get_filename_component(folder "${folder}" ABSOLUTE)
  file(GLOB files CONFIGURE_DEPENDS "${folder}/*.json")
  # The list of names is an input of its own: a removed file changes no other one.
  set(list "${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.txt")
  list(JOIN files "\n" lines)
  file(CONFIGURE OUTPUT "${list}" CONTENT "${lines}\n" @ONLY)
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DLIST=${list}" "-DOUTPUT=${output}" "-DNAME=${name}" -P "${script}"
    DEPENDS ${files} "${list}" "${script}" "${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake" VERBATIM)
  target_sources(${target} PRIVATE "${output}")
endfunction()

# tyndall_embed_folder(TARGET FOLDER NAME TYPE HEADER): an array NAME[] of TYPE, which HEADER has, from the folder's files.
function(tyndall_embed_folder target folder name type header)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.c")
  set(script "${PROJECT_SOURCE_DIR}/cmake/embed_folder.cmake")
  get_filename_component(folder "${folder}" ABSOLUTE)
  file(GLOB files CONFIGURE_DEPENDS "${folder}/*.*")
  set(list "${CMAKE_CURRENT_BINARY_DIR}/embedded/${name}.txt")
  list(JOIN files "\n" lines)
  file(CONFIGURE OUTPUT "${list}" CONTENT "${lines}\n" @ONLY)
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DLIST=${list}" "-DOUTPUT=${output}" "-DHEADER=${header}" "-DTYPE=${type}"
      "-DNAME=${name}" -P "${script}"
    DEPENDS ${files} "${list}" "${script}" "${PROJECT_SOURCE_DIR}/cmake/embed_bytes.cmake" VERBATIM)
  target_sources(${target} PRIVATE "${output}")
endfunction()

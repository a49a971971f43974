# The extension module of the Python package (python/), in build/python/tyndall beside links to the package's files, so
# that PYTHONPATH=build/python imports it. Only Python's own headers are needed.
include_guard()

# The Python, 3.11 or later, for which the module is built and tested: the system's rather than another in PATH.
find_program(TYNDALL_PYTHON_EXECUTABLE python3 PATHS /usr/bin NO_DEFAULT_PATH)
find_program(TYNDALL_PYTHON_EXECUTABLE python3)
set(TYNDALL_PYTHON_SOURCES "${PROJECT_SOURCE_DIR}/python" CACHE PATH "The package's folder, for setup.py")
mark_as_advanced(TYNDALL_PYTHON_SOURCES)
set(TYNDALL_PYTHON_INCLUDE "")
if(TYNDALL_PYTHON_EXECUTABLE)
  execute_process(COMMAND "${TYNDALL_PYTHON_EXECUTABLE}" -c
    "import sys, sysconfig; print(sysconfig.get_paths()['include'] if sys.version_info >= (3, 11) else '')"
    OUTPUT_VARIABLE TYNDALL_PYTHON_INCLUDE OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT EXISTS "${TYNDALL_PYTHON_INCLUDE}/Python.h")
  message(STATUS "Without the headers of Python 3.11 or later (python3-dev) there is no Python module")
  return()
endif()

file(GLOB sources CONFIGURE_DEPENDS "${TYNDALL_PYTHON_SOURCES}/src/*.c")
add_library(tyndall_python MODULE ${sources})
target_include_directories(tyndall_python SYSTEM PRIVATE "${TYNDALL_PYTHON_INCLUDE}")
target_link_libraries(tyndall_python PRIVATE tyndall_static tyndall_options m)
target_link_options(tyndall_python PRIVATE "LINKER:--exclude-libs,ALL")
set_target_properties(tyndall_python PROPERTIES PREFIX "" OUTPUT_NAME _core SUFFIX .abi3.so
  LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/python/tyndall")
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/python/tyndall")
file(GLOB files CONFIGURE_DEPENDS RELATIVE "${TYNDALL_PYTHON_SOURCES}/tyndall"
  "${TYNDALL_PYTHON_SOURCES}/tyndall/*.py" "${TYNDALL_PYTHON_SOURCES}/tyndall/*.pyi"
  "${TYNDALL_PYTHON_SOURCES}/tyndall/py.typed")
foreach(file IN LISTS files)
  file(CREATE_LINK "${TYNDALL_PYTHON_SOURCES}/tyndall/${file}" "${PROJECT_BINARY_DIR}/python/tyndall/${file}" SYMBOLIC)
endforeach()

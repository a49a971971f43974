# Debian packages, by cpack: tyndall (the tool, its programs, manual pages, completion), libtyndallVERSION (the library),
# libtyndall-dev, and tyndall-mpi (the tool's module for several machines). Dependencies are found by dpkg-shlibdeps. scripts/package.sh makes them, scripts/try_package.sh tries them.
set(release 1)
set(library_package "libtyndall${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}") # as its soname
set(package_of_tool tyndall)
set(package_of_library ${library_package})
set(package_of_development libtyndall-dev)
set(package_of_mpi tyndall-mpi)
set(components tool library development)
if(TYNDALL_MPI)
  list(APPEND components mpi)
endif()

set(TYNDALL_MAINTAINER "The Tyndall maintainers <tyndall@localhost>" CACHE STRING "Name and address in packages")
string(TIMESTAMP TYNDALL_PACKAGE_DATE "%a, %d %b %Y %H:%M:%S +0000" UTC)
configure_file("${PROJECT_SOURCE_DIR}/cmake/debian/changelog.in" "${PROJECT_BINARY_DIR}/package/changelog.Debian" @ONLY)
execute_process(COMMAND gzip -9nf "${PROJECT_BINARY_DIR}/package/changelog.Debian" COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS components)
  install(FILES "${PROJECT_SOURCE_DIR}/cmake/debian/copyright" "${PROJECT_BINARY_DIR}/package/changelog.Debian.gz"
    DESTINATION "${CMAKE_INSTALL_DATADIR}/doc/${package_of_${component}}" COMPONENT ${component})
endforeach()
install(CODE "
  file(GLOB pages \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1/*.1\")
  execute_process(COMMAND gzip -9nf \${pages} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT tool)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tyndall)
set(CPACK_PACKAGE_CONTACT "${TYNDALL_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX "${CMAKE_INSTALL_PREFIX}")
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${release})
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(about "Tyndall computes the light in fog, smoke, clouds, milk and water: by path
 tracing, which is the reference, and by fast methods that are measured
 against it.")
set(CPACK_DEBIAN_TOOL_PACKAGE_NAME ${package_of_tool})
set(CPACK_DEBIAN_TOOL_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_TOOL_PACKAGE_RECOMMENDS fonts-dejavu-core) # text of figures
set(CPACK_DEBIAN_TOOL_DESCRIPTION "light transport in participating media (command-line tool)\n${about}")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${package_of_library})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS libnetcdf19) # loaded where NetCDF files are read
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "light transport in participating media (shared library)\n${about}")
set(CPACK_DEBIAN_MPI_PACKAGE_NAME ${package_of_mpi})
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "${package_of_tool} (= ${PROJECT_VERSION}-${release})")
set(CPACK_DEBIAN_MPI_DESCRIPTION "light transport in participating media (several machines, by MPI)\n${about}")
set(control "${PROJECT_BINARY_DIR}/package/library")
file(CONFIGURE OUTPUT "${control}/triggers" CONTENT "activate-noawait ldconfig\n")
file(CONFIGURE OUTPUT "${control}/shlibs"
  CONTENT "libtyndall ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} ${library_package} (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${control}/triggers" "${control}/shlibs")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME ${package_of_development})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${library_package} (= ${PROJECT_VERSION}-${release})")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "light transport in participating media (development files)\n${about}")
include(CPack)

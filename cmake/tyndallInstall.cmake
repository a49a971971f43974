# What `cmake --install` puts where: library, headers, tool, pkg-config file, CMake package. Its components (tool, library,
# development) are the packages of tyndallPackage.cmake.
include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/tyndall")
install(TARGETS tyndall EXPORT tyndallTargets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library NAMELINK_COMPONENT development)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/tyndall" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
  COMPONENT development FILES_MATCHING PATTERN "*.h")
if(TYNDALL_CLI)
  install(TARGETS tyndall_cli RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tool)
  if(TYNDALL_MPI) # a package of its own, which alone needs MPI
    install(TARGETS tyndall_mpi LIBRARY DESTINATION "${CMAKE_INSTALL_LIBEXECDIR}/tyndall" COMPONENT mpi)
  endif()
endif()
if(NOT TYNDALL_PACKAGE) # packages have a file of Debian's form in its place
  install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT tool)
endif()

install(EXPORT tyndallTargets NAMESPACE tyndall:: DESTINATION "${package_dir}" COMPONENT development)
set(TYNDALL_DECODERS "")
foreach(decoder DRACO MESHOPT WEBP EXPAT TIFF CHARLS OPENJPEG ZSTD DICOM_JPEG)
  if(TYNDALL_${decoder})
    string(APPEND TYNDALL_DECODERS " ${decoder}")
  endif()
endforeach()
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/tyndallConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/package/tyndallConfig.cmake" INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/package/tyndallConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)
install(FILES
  "${PROJECT_BINARY_DIR}/package/tyndallConfig.cmake"
  "${PROJECT_BINARY_DIR}/package/tyndallConfigVersion.cmake"
  "${PROJECT_SOURCE_DIR}/cmake/tyndallDependencies.cmake"
  DESTINATION "${package_dir}" COMPONENT development)

# A static library's users link what it is made of; a shared one brings it along.
set(TYNDALL_PC_REQUIRES "")
set(TYNDALL_PC_LIBS "")
if(NOT BUILD_SHARED_LIBS)
  set(TYNDALL_PC_REQUIRES "jansson libpng libjpeg zlib blosc")
  set(TYNDALL_PC_LIBS " -lembree3 -lOpenEXR -lIex -lOpenEXRCore -lImath -lstdc++ -lm -pthread")
  if(TYNDALL_DRACO)
    string(APPEND TYNDALL_PC_LIBS " -ldraco")
  endif()
  if(TYNDALL_MESHOPT)
    string(APPEND TYNDALL_PC_LIBS " -lmeshoptimizer")
  endif()
  if(TYNDALL_WEBP)
    string(APPEND TYNDALL_PC_LIBS " -lwebp")
  endif()
  if(TYNDALL_EXPAT)
    string(APPEND TYNDALL_PC_LIBS " -lexpat")
  endif()
  if(TYNDALL_TIFF)
    string(APPEND TYNDALL_PC_LIBS " -ltiff")
  endif()
  if(TYNDALL_CHARLS)
    string(APPEND TYNDALL_PC_LIBS " -lcharls")
  endif()
  if(TYNDALL_OPENJPEG)
    string(APPEND TYNDALL_PC_LIBS " -lopenjp2")
  endif()
  if(TYNDALL_ZSTD)
    string(APPEND TYNDALL_PC_LIBS " -lzstd")
  endif()
  if(TYNDALL_DICOM_JPEG)
    string(APPEND TYNDALL_PC_LIBS " -lgdcmjpeg8 -lgdcmjpeg12 -lgdcmjpeg16")
  endif()
endif()
file(RELATIVE_PATH TYNDALL_PC_UP "${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig" "${CMAKE_INSTALL_PREFIX}")
file(RELATIVE_PATH TYNDALL_PC_LIBDIR "${CMAKE_INSTALL_PREFIX}" "${CMAKE_INSTALL_FULL_LIBDIR}")
file(RELATIVE_PATH TYNDALL_PC_INCLUDEDIR "${CMAKE_INSTALL_PREFIX}" "${CMAKE_INSTALL_FULL_INCLUDEDIR}")
configure_file("${PROJECT_SOURCE_DIR}/cmake/tyndall.pc.in" "${PROJECT_BINARY_DIR}/package/tyndall.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/package/tyndall.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT development)

# What the library is made of. The build includes this, and so does the installed package of a static library: an
# archive does not know what it needs.
find_package(Threads REQUIRED)
find_package(embree 3 REQUIRED) # brings TBB::tbb
find_package(OpenEXR CONFIG REQUIRED) # brings Imath::Imath
find_package(PNG REQUIRED)
find_package(JPEG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(PkgConfig REQUIRED)

foreach(library jansson blosc)
  string(TOUPPER ${library} name)
  if(NOT TARGET PkgConfig::${name})
    pkg_check_modules(${name} REQUIRED IMPORTED_TARGET GLOBAL ${library})
  endif()
endforeach()

find_path(TYNDALL_NANOVDB_INCLUDE_DIR nanovdb/PNanoVDB.h REQUIRED) # headers only
mark_as_advanced(TYNDALL_NANOVDB_INCLUDE_DIR)

# Decoders of compressed glTF files, WebP images and XML. A build without one refuses files that need it.
option(TYNDALL_DRACO "Read glTF meshes compressed by Draco" ON)
option(TYNDALL_MESHOPT "Read glTF meshes compressed by meshoptimizer" ON)
option(TYNDALL_WEBP "Read WebP images" ON)
option(TYNDALL_EXPAT "Read VTK's .vti volumes, whose headers are XML" ON)
if(TYNDALL_DRACO)
  find_package(draco CONFIG REQUIRED)
endif()
if(TYNDALL_MESHOPT)
  find_package(meshoptimizer CONFIG REQUIRED)
endif()
if(TYNDALL_WEBP AND NOT TARGET PkgConfig::WEBP)
  pkg_check_modules(WEBP REQUIRED IMPORTED_TARGET GLOBAL libwebp)
endif()
if(TYNDALL_EXPAT AND NOT TARGET PkgConfig::EXPAT)
  pkg_check_modules(EXPAT REQUIRED IMPORTED_TARGET GLOBAL expat)
endif()

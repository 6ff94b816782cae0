# Finds the libraries, which are packages of Debian 12 (packages.txt has their names). Where find_package alone is not enough, a
# comment says why.
find_package(Threads REQUIRED)
find_package(glm REQUIRED)
find_package(hwy REQUIRED)
find_package(TinyGLTF REQUIRED)
find_package(tinyobjloader REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenEXR REQUIRED)
find_package(PNG REQUIRED)
find_package(CLI11 REQUIRED)

# OpenImageIO 2.4's own config asks for its command line tools and names an include folder of OpenCV that no package
# provides.
find_path(OCCAM_OIIO_INCLUDE OpenImageIO/imageio.h REQUIRED)
find_library(OCCAM_OIIO_LIBRARY OpenImageIO REQUIRED)
find_library(OCCAM_OIIO_UTIL_LIBRARY OpenImageIO_Util REQUIRED)
add_library(occam_oiio INTERFACE)
target_include_directories(occam_oiio SYSTEM INTERFACE ${OCCAM_OIIO_INCLUDE})
target_link_libraries(occam_oiio INTERFACE ${OCCAM_OIIO_LIBRARY} ${OCCAM_OIIO_UTIL_LIBRARY} OpenEXR::OpenEXR)

# Debian's libwebp has no config of CMake.
find_path(OCCAM_WEBP_INCLUDE webp/demux.h REQUIRED)
find_library(OCCAM_WEBP_LIBRARY webp REQUIRED)
find_library(OCCAM_WEBP_DEMUX_LIBRARY webpdemux REQUIRED)
add_library(occam_webp INTERFACE)
target_include_directories(occam_webp SYSTEM INTERFACE ${OCCAM_WEBP_INCLUDE})
target_link_libraries(occam_webp INTERFACE ${OCCAM_WEBP_DEMUX_LIBRARY} ${OCCAM_WEBP_LIBRARY})

# OpenSubdiv 3.5's own config names a static library that is not packaged.
find_path(OCCAM_OSD_INCLUDE opensubdiv/bfr/surface.h REQUIRED)
find_library(OCCAM_OSD_LIBRARY osdCPU REQUIRED)
add_library(occam_osd INTERFACE)
target_include_directories(occam_osd SYSTEM INTERFACE ${OCCAM_OSD_INCLUDE})
target_link_libraries(occam_osd INTERFACE ${OCCAM_OSD_LIBRARY})

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

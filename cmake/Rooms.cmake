# A room is a folder and an object library: occam_room(name ROOMS rooms-it-may-include LIBRARIES private-libraries).
# Its include path is the repository's root, so that an #include names the room.
set(OCCAM_ROOMS "")

function(occam_room name)
  cmake_parse_arguments(ROOM "" "" "ROOMS;LIBRARIES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${name}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/picture_module/")
  if(NOT sources)
    return()
  endif()
  add_library(occam_${name} OBJECT ${sources})
  occam_batches(occam_${name} ${sources})
  target_include_directories(occam_${name} PUBLIC ${PROJECT_SOURCE_DIR} ${CMAKE_BINARY_DIR}/generated)
  target_link_libraries(occam_${name} PUBLIC occam_flags glm::glm hwy::hwy Threads::Threads PRIVATE ${ROOM_LIBRARIES})
  if(OCCAM_QUICK_BUILD AND TARGET occam_base AND NOT name STREQUAL base)
    target_precompile_headers(occam_${name} REUSE_FROM occam_base)
  else()
    target_precompile_headers(occam_${name} PRIVATE
      <algorithm> <cmath> <cstdint> <memory> <span> <string> <vector> ${PROJECT_SOURCE_DIR}/base/box.h
      ${OCCAM_QUICK_HEADERS})
  endif()
  if(name STREQUAL base)
    # So that g++ makes loops of them of SIMD instructions. Nothing reads the flags of floating-point exceptions. Elsewhere this
    # option costs more than it gains: g++ then divides pairs of floats as fours, and what is in the other two may be denormal.
    set_source_files_properties(${PROJECT_SOURCE_DIR}/base/maths.cpp PROPERTIES COMPILE_OPTIONS -fno-trapping-math)
  endif()
  if(name STREQUAL io)
    set_source_files_properties(${PROJECT_SOURCE_DIR}/io/picture_codec.cpp
      PROPERTIES COMPILE_DEFINITIONS OCCAM_PICTURE_MODULE="liboccam_images.so.${PROJECT_VERSION_MAJOR}")
  endif()
  set(OCCAM_ROOMS ${OCCAM_ROOMS} occam_${name} PARENT_SCOPE)
  set(OCCAM_ROOM_LIBRARIES ${OCCAM_ROOM_LIBRARIES} ${ROOM_LIBRARIES} PARENT_SCOPE)
endfunction()

# The module with all that needs OpenImageIO or libwebp. It stands beside the library, which loads it when it first meets a picture file.
function(occam_picture_module)
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/io/picture_module/*.cpp)
  add_library(occam_images SHARED ${sources})
  target_include_directories(occam_images PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(occam_images PRIVATE occam_flags occam_oiio occam_webp)
  set_target_properties(occam_images PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}
    CXX_VISIBILITY_PRESET hidden)
  add_dependencies(occam occam_images)
endfunction()

function(occam_library)
  add_library(occam SHARED)
  add_library(occam::occam ALIAS occam)
  foreach(room ${OCCAM_ROOMS})
    target_sources(occam PRIVATE $<TARGET_OBJECTS:${room}>)
  endforeach()
  target_link_libraries(occam PUBLIC glm::glm
    PRIVATE occam_flags hwy::hwy Threads::Threads ${OCCAM_ROOM_LIBRARIES} ${CMAKE_DL_LIBS})
  target_include_directories(occam PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/api/include>
    $<INSTALL_INTERFACE:include>
    $<INSTALL_INTERFACE:include/occam>)
  target_compile_features(occam PUBLIC cxx_std_20)
  target_link_options(occam PRIVATE -Wl,-z,nodelete)  # threads are kept that wait in its code
  set_target_properties(occam PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
endfunction()

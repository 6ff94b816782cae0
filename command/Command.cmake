# Builds the executable `occam`, which is linked to the shared library.
file(GLOB occam_command_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/command/*.cpp)
target_sources(occam_cli PRIVATE ${occam_command_sources})
occam_batches(occam_cli ${occam_command_sources})
target_include_directories(occam_cli PRIVATE ${PROJECT_SOURCE_DIR}/api/command)
target_link_libraries(occam_cli PRIVATE occam occam_flags CLI11::CLI11 nlohmann_json::nlohmann_json)
set_target_properties(occam_cli PROPERTIES OUTPUT_NAME occam)

# Collects the names and versions of the libraries that --version prints.
set(occam_libraries "oneTBB ${TBB_VERSION}, nlohmann json ${nlohmann_json_VERSION}, CLI11 ${CLI11_VERSION}, GLM ${glm_VERSION}")
string(APPEND occam_libraries ", Highway ${hwy_VERSION}, tinygltf ${TinyGLTF_VERSION}, tinyobjloader ${tinyobjloader_VERSION}")
foreach(header_of_library "OpenImageIO;OpenImageIO/oiioversion.h;OIIO_VERSION_" "OpenSubdiv;opensubdiv/version.h;OPENSUBDIV_VERSION_")
  list(GET header_of_library 0 library)
  list(GET header_of_library 1 header)
  list(GET header_of_library 2 prefix)
  find_file(occam_${library}_version_header ${header})
  file(STRINGS ${occam_${library}_version_header} lines REGEX "define ${prefix}(MAJOR|MINOR|PATCH|NUMBER)")
  string(REGEX MATCH "MAJOR +([0-9]+)" unused "${lines}")
  set(version ${CMAKE_MATCH_1})
  string(REGEX MATCH "MINOR +([0-9]+)" unused "${lines}")
  string(APPEND version ".${CMAKE_MATCH_1}")
  string(REGEX MATCH "PATCH +([0-9]+)" unused "${lines}")
  string(APPEND version ".${CMAKE_MATCH_1}")
  string(APPEND occam_libraries ", ${library} ${version}")
endforeach()
set_source_files_properties(${PROJECT_SOURCE_DIR}/command/parse.cpp
  PROPERTIES COMPILE_DEFINITIONS "OCCAM_LIBRARIES=\"${occam_libraries}\"")
# Parsing arguments needs no speed, and CLI11 takes half a minute to optimise.
set_source_files_properties(${PROJECT_SOURCE_DIR}/command/parse.cpp ${PROJECT_SOURCE_DIR}/command/parse_motion.cpp
  ${PROJECT_SOURCE_DIR}/command/parse_replay.cpp ${PROJECT_SOURCE_DIR}/command/parse_settings.cpp
  ${PROJECT_SOURCE_DIR}/command/parse_compare.cpp
  ${PROJECT_SOURCE_DIR}/command/usage_message.cpp
  PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:Release>:-O1>")

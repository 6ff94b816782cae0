# `cmake --install` installs the library and its picture module, the command, the headers that occam/occam.h includes, and a package for
# find_package(occam).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Collects everything that `header` (relative to the root) includes by a quoted path from the root or from api/include, and
# what that includes in turn.
function(occam_headers_reached header reached)
  set(todo ${header})
  set(done "")
  while(todo)
    list(POP_FRONT todo next)
    if(next IN_LIST done)
      continue()
    endif()
    list(APPEND done ${next})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${next})
    file(STRINGS ${PROJECT_SOURCE_DIR}/${next} lines REGEX "^#include \"")
    foreach(line ${lines})
      string(REGEX REPLACE "^#include \"([^\"]+)\".*" "\\1" included "${line}")
      foreach(folder "" api/include/)
        if(EXISTS ${PROJECT_SOURCE_DIR}/${folder}${included})
          list(APPEND todo ${folder}${included})
        endif()
      endforeach()
    endforeach()
  endwhile()
  set(${reached} ${done} PARENT_SCOPE)
endfunction()

function(occam_install)
  set_target_properties(occam_cli PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
  install(TARGETS occam EXPORT occam_targets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
  # Nobody links the module, so the names that links use are not installed.
  install(TARGETS occam_images LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} NAMELINK_SKIP)
  install(TARGETS occam_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

  # This installs include/occam/occam.h itself and, below include/occam/, the rooms' headers under the names by which it
  # includes them.
  occam_headers_reached(api/include/occam/occam.h headers)
  foreach(header ${headers})
    cmake_path(GET header PARENT_PATH folder)
    string(REGEX REPLACE "^api/include/occam" "" folder "${folder}")
    install(FILES ${PROJECT_SOURCE_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/occam/${folder})
  endforeach()

  set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/occam)
  install(EXPORT occam_targets NAMESPACE occam:: FILE occamTargets.cmake DESTINATION ${package_folder})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/occamConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/occamConfig.cmake ${PROJECT_BINARY_DIR}/occamConfigVersion.cmake
    DESTINATION ${package_folder})
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
endfunction()

# With OCCAM_QUICK_BUILD several source files are compiled as one, so that headers are read and templates are made once for all of
# them. Files that give the same name to something at the outermost level (in unnamed namespaces) go into different batches, which
# this file finds out by itself.
set(OCCAM_BATCH_LINES 1500)  # the most lines of a batch, which a core compiles in about ten seconds
# Headers that most batches include. They are precompiled with OCCAM_QUICK_BUILD only, so that other builds find out what a file does not
# include by itself.
set(OCCAM_QUICK_HEADERS "")
if(OCCAM_QUICK_BUILD)
  set(OCCAM_QUICK_HEADERS <atomic> <chrono> <functional> <map> <optional> <random> <sstream> <unordered_map> <variant>
    ${PROJECT_SOURCE_DIR}/base/simd.h ${PROJECT_SOURCE_DIR}/scenegraph/scene.h)
endif()

# Sets `names` to what a source file defines at the start of a line: functions, types, constants and aliases.
function(occam_outermost_names source names)
  set(found "")
  file(STRINGS ${source} lines REGEX "^[A-Za-z].*[({;=]|^(struct|class|enum) ")
  foreach(line IN LISTS lines)
    # run() is overloaded for the arguments of each command (command/arguments.h).
    if(line MATCHES "^(TEST|INSTANTIATE|namespace |using namespace|using [a-z_]+::|int run\\(const )")
      continue()
    elseif(line MATCHES "^(struct|class|enum class|enum|using) ([A-Za-z_0-9]+)")
      list(APPEND found ${CMAKE_MATCH_2})
    elseif(line MATCHES "^[^(={]*[ &*]([A-Za-z_0-9]+)[ ]*[(={;[]")
      list(APPEND found ${CMAKE_MATCH_1})
    endif()
  endforeach()
  set(${names} ${found} PARENT_SCOPE)
endfunction()

# Compiles the sources of a target in batches, each of at most OCCAM_BATCH_LINES lines and without a name that is defined twice.
function(occam_batches target)
  if(NOT OCCAM_QUICK_BUILD)
    return()
  endif()
  set(count 0)
  foreach(source ${ARGN})
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${source})
    occam_outermost_names(${source} names)
    file(STRINGS ${source} lines REGEX "[^ ]")
    list(LENGTH lines length)
    set(batch 0)
    while(batch LESS count)
      set(is_free TRUE)
      math(EXPR sum "${length_${batch}} + ${length}")
      foreach(name ${names})
        if(name IN_LIST names_${batch})
          set(is_free FALSE)
        endif()
      endforeach()
      if(is_free AND sum LESS_EQUAL OCCAM_BATCH_LINES)
        break()
      endif()
      math(EXPR batch "${batch} + 1")
    endwhile()
    if(batch EQUAL count)
      math(EXPR count "${count} + 1")
      set(length_${batch} 0)
      set(names_${batch} "")
    endif()
    math(EXPR length_${batch} "${length_${batch}} + ${length}")
    list(APPEND names_${batch} ${names})
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${batch})
  endforeach()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # A batch is not a header: what a type takes from an unnamed namespace of its own file stays in one translation unit.
    target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

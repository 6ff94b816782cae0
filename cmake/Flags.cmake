set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")

# Objects are kept from build to build where ccache is installed; it has to be told to trust precompiled headers.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE_PROGRAM})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-fpch-preprocess)
  endif()
endif()

add_library(occam_flags INTERFACE)
# Every code path, compiler and lane count must give the same bits: nothing is contracted, and nothing is assumed about NaN.
# Calls within the shared library are direct: its functions are not replaced at load time.
target_compile_options(occam_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Werror -ffp-contract=off -fno-math-errno
  -fno-semantic-interposition -fvisibility-inlines-hidden)
# When the copy of a std::variant ends by an exception, g++ 12 has dropped the store that says that the copy is empty, and what was
# never made is destroyed (FailingCommand.EndsInOneLineWhereverMemoryEndsWhileAFileIsWritten).
target_compile_options(occam_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fno-lifetime-dse>)
if(OCCAM_QUICK_BUILD)
  # By default g++ looks for memory that it no longer needs many times while it compiles a batch.
  target_compile_options(occam_flags INTERFACE "$<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=400000>")
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # Highway's AVX2 target asks for AES and PCLMUL too; without them it silently becomes four lanes of SSSE3.
  target_compile_options(occam_flags INTERFACE -march=x86-64-v3 -maes -mpclmul)
endif()
if(OCCAM_ONE_LANE)
  target_compile_definitions(occam_flags INTERFACE OCCAM_ONE_LANE=1)
endif()
if(OCCAM_FUZZ)
  target_compile_options(occam_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(OCCAM_SANITIZE)
  target_compile_options(occam_flags INTERFACE -fsanitize=${OCCAM_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all -g1)
  target_link_options(occam_flags INTERFACE -fsanitize=${OCCAM_SANITIZE})
  if(OCCAM_SANITIZE MATCHES "address")
    set(options_source ${CMAKE_CURRENT_LIST_DIR}/sanitizer_options.cpp)
    target_sources(occam_flags INTERFACE $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:${options_source}>)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # Instrumented code triggers these warnings of g++ 12 wrongly; the other builds keep them.
    target_compile_options(occam_flags INTERFACE -Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow)
  endif()
endif()

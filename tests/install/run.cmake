# cmake -D BUILD=build-folder -P run.cmake
# Installs a build into a fresh prefix, builds the external project beside this file against it, and runs both programs.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT OUTPUT_VARIABLE out ERROR_VARIABLE out RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "exit code ${result}:\n${out}")
  endif()
endfunction()

set(work ${BUILD}/install_test)
set(prefix ${work}/prefix)
file(REMOVE_RECURSE ${work})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})

load_cache(${BUILD} READ_WITH_PREFIX built_ CMAKE_GENERATOR CMAKE_CXX_COMPILER OCCAM_SANITIZE)
set(flags -Werror)
if(built_OCCAM_SANITIZE)  # the program's have to be those of the library
  string(APPEND flags " -fsanitize=${built_OCCAM_SANITIZE}")
endif()
run(${CMAKE_COMMAND} -G ${built_CMAKE_GENERATOR} -S ${CMAKE_CURRENT_LIST_DIR} -B ${work}/build
  -D CMAKE_CXX_COMPILER=${built_CMAKE_CXX_COMPILER} -D CMAKE_CXX_FLAGS=${flags} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${work}/build)

file(WRITE ${work}/triangle.obj "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n")
run(${work}/build/stranger ${work}/triangle.obj ${work}/stranger.exr)
run(${prefix}/bin/occam render ${work}/triangle.obj -o ${work}/command.exr --size 64x48 --spp 1)
run(${prefix}/bin/occam render ${work}/triangle.obj -o ${work}/command.png --size 64x48 --spp 1)
run(${prefix}/bin/occam compare ${work}/stranger.exr ${work}/command.exr --max-error 0)

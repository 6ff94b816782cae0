# find_package(occam) provides the target occam::occam. Vectors in the interface are GLM's; a user needs no other library.
include(CMakeFindDependencyMacro)
find_dependency(glm)
include(${CMAKE_CURRENT_LIST_DIR}/occamTargets.cmake)

# find_package(occam) gives the target occam::occam. Vectors in the interface are GLM's; a user needs nothing else.
include(CMakeFindDependencyMacro)
find_dependency(glm)
include(${CMAKE_CURRENT_LIST_DIR}/occamTargets.cmake)

// The subdivision shapes of the shared data, as parameters of tests.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::test {

/// Paths of all Catmull-Clark and bilinear shapes in subdiv/opensubdiv; empty without the shared data.
std::vector<std::string> subdivision_shapes();
/// Those of subdiv/ that are closed, any folder.
std::vector<std::string> closed_shapes();

/// Reads an OBJ as a cage of the scheme that its name begins with.
Cage load_cage(const std::string& path);

/// "catmark_cube" of ".../catmark_cube.obj".
std::string shape_test_name(const testing::TestParamInfo<std::string>& info);

}  // namespace occam::test

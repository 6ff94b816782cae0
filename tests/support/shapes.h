// The subdivision cages of tests as parameters: made ones always, those of the shared test data where it exists.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scenegraph/cage.h"

namespace occam::test {

/// Names the made cages ("made:cube"), then the files of all Catmull-Clark and bilinear shapes in subdiv/opensubdiv.
std::vector<std::string> subdivision_shapes();
/// Names the closed made cages, then the files of all closed cages below subdiv/.
const std::vector<std::string>& closed_shapes();

/// Names closed_shapes() in the long form. Otherwise it names one cage of each kind, which is the smallest one as a rule: of
/// quads, of triangles, of n-gons, of all three, with poles, with concave corners, with a hole through it, bilinear, and
/// with each kind of crease. Of the files it names few, among them one in which a fault was found.
std::vector<std::string> chosen_closed_shapes();

/// Names the closed made cages that have no creases and no corners: all in the long form, else those of few faces.
std::vector<std::string> closed_cages_without_creases();

/// Returns the made cage of that name, or reads an OBJ as a cage of the scheme that its name begins with.
Cage load_cage(const std::string& name);

/// Returns "catmark_cube" for ".../catmark_cube.obj" and "made_cube" for "made:cube".
std::string shape_test_name(const testing::TestParamInfo<std::string>& info);

}  // namespace occam::test

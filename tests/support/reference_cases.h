// The cases of shared/reference: which model, from which camera, and how close a correct picture must come.
#pragma once

#include <filesystem>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "scenegraph/cage.h"
#include "scenegraph/camera.h"
#include "tests/support/reference_compare.h"

namespace occam::test {

struct ReferenceCase {
    std::string id;
    std::filesystem::path model;
    bool is_subdivision = false;
    int clip = -1;                                        ///< index of a clip of the file; below 0: none
    double seconds = 0;                                   ///< on the clip's own axis
    BoundaryRule boundary = BoundaryRule::EdgeAndCorner;  ///< rule for subdivided files that do not state one
    int width = 0, height = 0;
    Camera camera;
    std::map<std::string, std::filesystem::path> files;  ///< one for each layer: "depth", "normal_geometric", ...

    ReferenceLimits limits;
    /// The shares that must be reached; a layer without a requirement has none. coverage_mismatch and albedo_mean_absolute
    /// are upper bounds.
    ReferenceShares least;

    friend std::ostream& operator<<(std::ostream& out, const ReferenceCase& c) { return out << c.id; }
};

/// Returns all cases in the order of cases.json; none if the shared data is absent. Throws Error naming case and entry if
/// the file is not as expected.
std::vector<ReferenceCase> reference_cases();

/// Returns the reference's pictures. Throws Error.
ReferencePicture read_reference(const ReferenceCase& c);

/// Returns the id of a case in letters that the name of a test may have.
std::string reference_test_name(const ReferenceCase& c);

}  // namespace occam::test

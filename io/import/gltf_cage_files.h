// The cages that nodes of a glTF name by their files (extras.occam.cage).
#pragma once

#include "io/import/copy_budget.h"
#include "io/import/gltf_materials.h"
#include "io/import/gltf_occam.h"
#include "io/import/import.h"

namespace occam::import {

class CageFiles {
public:
    CageFiles(MaterialImporter& materials, Scene& scene, Report& report, CopyBudget& copies, const LoadOptions& options)
        : materials_(materials), scene_(scene), report_(report), copies_(copies), options_(options)
    {
    }

    /// Returns the cage of the file that the extras name, in their style. A file is read at most a few times, whatever names
    /// and styles it is asked for by; the styles that differ in numbers get copies of the cage. Throws Error if the file is
    /// outside of the scene's folder or cannot be read, or if the copies take far more memory than the file.
    CageId cage(const NodeExtras& extras, const std::string& where);

private:
    /// Says what decides how the file is read.
    struct Reading {
        std::string path;  ///< canonical
        bool with_materials = false;
        std::optional<CageStyle::Scheme> scheme;
        auto operator<=>(const Reading&) const = default;
    };
    /// Holds the first cage of a reading, and what its style may have changed.
    struct Source {
        CageId cage;
        BoundaryRule boundary = BoundaryRule::EdgeAndCorner;
        FaceVaryingRule face_varying = FaceVaryingRule::CornersPlus1;
    };
    Cage read(const NodeExtras& extras, Reading& reading);
    const std::string& canonical(const std::string& name, const std::string& where);

    MaterialImporter& materials_;
    Scene& scene_;
    Report& report_;
    CopyBudget& copies_;
    const LoadOptions& options_;
    std::map<std::string, std::string> paths_;  ///< canonical ones, by the names in the file
    std::set<std::string> without_libraries_;   ///< paths of files that name no libraries of materials
    std::map<Reading, Source> sources_;
    std::map<std::pair<Reading, CageStyle>, CageId> cages_;
};

}  // namespace occam::import

// Conversion of the meshes of a glTF into cages: triangles as they are, or polygons of a subdivision cage.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/import/gltf_materials.h"
#include "io/import/gltf_occam.h"
#include "io/import/import.h"

namespace occam::import {

class MeshImporter {
public:
    MeshImporter(const tinygltf::Model& model, AccessorReader& accessors, MaterialImporter& materials, Scene& scene,
                 Report& report, const LoadOptions& options)
        : model_(model), accessors_(accessors), materials_(materials), scene_(scene), report_(report), options_(options)
    {
    }

    /// Sets the number of the variant whose materials primitives get; -1 means their own.
    void set_variant(int variant) noexcept { variant_ = variant; }

    /// Returns one cage for each primitive. If the mesh is to be subdivided it is one cage, or two where only some
    /// primitives have joints. They are made once for each (mesh, style): the primitives are read for the first style, and
    /// other styles get copies of its cages, which are charged.
    const std::vector<CageId>& cages(int mesh, const CageStyle& style);

private:
    struct PrimitiveCage {
        Cage cage;                  ///< Scheme::Triangles
        bool has_polygons = false;  ///< FB_ngon_encoding
    };
    /// Makes the cages of a mesh without a style.
    std::vector<Cage> made(const tinygltf::Mesh& mesh, const std::string& where, bool is_subdivided);
    /// Returns a charged copy of a cage of another style, without that style.
    Cage copy(CageId source, const std::string& where, bool is_subdivided);
    CageId add(Cage cage, const CageStyle& style, const std::string& where);
    /// Joins the primitives of a mesh that is to be subdivided, so that no crease is between them, and welds their vertices.
    /// A skin moves a primitive as a whole or not at all, so those with joints are apart from those without.
    std::vector<Cage> joined(std::vector<Cage> parts, const std::string& where);
    std::optional<PrimitiveCage> read(const tinygltf::Primitive& primitive, const std::string& where);
    /// The vertices that the accessors of a primitive hold, and those of them that it uses.
    struct Vertices {
        std::size_t count;
        ChosenElements used;
    };
    std::vector<std::uint32_t> triangles(const tinygltf::Primitive& primitive, int position, const std::string& where);
    /// Returns the index of the primitive's material, or of the chosen variant's if that maps it (KHR_materials_variants).
    int material_index(const tinygltf::Primitive& primitive) const;
    void read_attributes(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage,
                         const std::string& where);
    void read_skin(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage, const std::string& where);
    void read_morph_targets(const tinygltf::Primitive& primitive, const Vertices& vertices, Cage& cage,
                            const std::string& where);
    /// Returns the accessor if it has a value for each vertex; throws Error if not.
    int per_vertex(int accessor, const Vertices& vertices, const char* name, const std::string& where) const;

    const tinygltf::Model& model_;
    AccessorReader& accessors_;
    MaterialImporter& materials_;
    Scene& scene_;
    Report& report_;
    const LoadOptions& options_;
    int variant_ = -1;
    std::map<std::pair<int, CageStyle>, std::vector<CageId>> cages_;
    std::map<std::pair<int, bool>, std::vector<CageId>> sources_;  ///< the first, by mesh and whether it is subdivided
};

}  // namespace occam::import

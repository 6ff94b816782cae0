#include "io/import/obj.h"

#include <tiny_obj_loader.h>

#include <limits>
#include <map>
#include <optional>
#include <unordered_map>

#include "io/import/files.h"
#include "io/import/mtl.h"
#include "io/import/obj_statements.h"
#include "io/import/words.h"

namespace occam::import {

namespace {

// Fills Polygons from tinyobjloader's callbacks. (Its LoadObj() counts a face's corners in a byte and drops degenerate
// faces, so that the numbers in hole tags no longer fit; the callbacks do neither.)
class Collector {
public:
    /// materials   null if none are wanted or no library could be read
    Collector(Polygons& polygons, const ObjStatements& counts, const std::map<std::string, MaterialId>* materials,
              Report& report)
        : polygons_(polygons), cage_(polygons.cage), materials_(materials), report_(report)
    {
        cage_.uv_sets.resize(1);
        cage_.positions.reserve(counts.positions);
        cage_.face_sizes.reserve(counts.faces);
        cage_.face_vertices.reserve(counts.corners);
        uvs().values.reserve(counts.uvs);
        polygons.normals.reserve(counts.normals);
        if (counts.uvs > 0) uvs().indices.reserve(counts.corners);
        if (counts.normals > 0) polygons.normal_indices.reserve(counts.corners);
    }

    tinyobj::callback_t callbacks() const
    {
        tinyobj::callback_t calls;
        calls.vertex_cb = [](void* self, float x, float y, float z, float) {
            static_cast<Collector*>(self)->cage_.positions.emplace_back(x, y, z);
        };
        calls.normal_cb = [](void* self, float x, float y, float z) {
            static_cast<Collector*>(self)->polygons_.normals.emplace_back(x, y, z);
        };
        // In OBJ, v runs upwards.
        calls.texcoord_cb = [](void* self, float u, float v, float) {
            static_cast<Collector*>(self)->uvs().values.emplace_back(u, 1.0f - v);
        };
        calls.index_cb = [](void* self, tinyobj::index_t* corners, int count) {
            static_cast<Collector*>(self)->add_face({corners, static_cast<std::size_t>(count)});
        };
        calls.usemtl_cb = [](void* self, const char* name, int) { static_cast<Collector*>(self)->use_material(name); };
        return calls;
    }

    void finish()
    {
        // Coordinates after the last are reported with those of all kinds of files.
        if (before_first_uv_ > 0)
            report_.warn(std::to_string(before_first_uv_) +
                         " corners have no texture coordinates: the index is out of range");
        std::size_t no_normals = before_first_normal_;
        for (const std::uint32_t n : polygons_.normal_indices) no_normals += n != kNoIndex && n >= polygons_.normals.size();
        if (no_normals > 0) report_.warn(std::to_string(no_normals) + " corners have no normal: the index is out of range");
        const std::size_t corners = cage_.face_vertices.size();
        if (uvs().indices.empty()) cage_.uv_sets.clear();
        else uvs().indices.resize(corners, kNoIndex);
        if (polygons_.normal_indices.empty()) polygons_.normals.clear();
        else polygons_.normal_indices.resize(corners, kNoIndex);
        if (!cage_.colors.empty()) cage_.colors.resize(cage_.positions.size(), Vec4f(1));
        if (cage_.materials.size() < 2) cage_.face_slots.clear();
        if (cage_.materials.size() == 1 && !cage_.materials[0]) cage_.materials.clear();
        if (cage_.face_sizes.empty()) throw Error(report_.name(), "there is no face in it");
    }

    bool names_materials() const noexcept { return names_materials_; }

private:
    UvSet& uvs() { return cage_.uv_sets[0]; }

    // Indices are 1-based, or counted back from the last element so far; 0 means that the index is left out.
    static std::uint32_t resolve(int index, std::size_t so_far)
    {
        const std::int64_t i = index > 0 ? std::int64_t(index) - 1 : std::int64_t(so_far) + index;
        return index == 0 || i < 0 ? kNoIndex : static_cast<std::uint32_t>(i);
    }

    // Adds what the next corner has, if it has it; corners before it that have nothing get kNoIndex.
    void add_index(std::vector<std::uint32_t>& indices, int index, std::size_t so_far, std::size_t& before_first)
    {
        if (index == 0) return;
        const std::uint32_t i = resolve(index, so_far);
        if (i == kNoIndex) {
            ++before_first;
            return;
        }
        if (indices.size() < cage_.face_vertices.size()) indices.resize(cage_.face_vertices.size(), kNoIndex);
        indices.push_back(i);
    }

    void add_face(std::span<const tinyobj::index_t> corners)
    {
        for (const tinyobj::index_t& c : corners) {
            add_index(uvs().indices, c.texcoord_index, uvs().values.size(), before_first_uv_);
            add_index(polygons_.normal_indices, c.normal_index, polygons_.normals.size(), before_first_normal_);
            cage_.face_vertices.push_back(resolve(c.vertex_index, cage_.positions.size()));
        }
        cage_.face_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
        if (!materials_ || materials_->empty()) return;
        if (!slot_) use_material("");
        cage_.face_slots.push_back(*slot_);
    }

    // A name that no library has gets a slot without a material, so the default material is seen.
    void use_material(const std::string& rest)
    {
        std::string name(Words(rest).rest());
        names_materials_ |= !name.empty();
        if (!materials_) return;
        auto material = materials_->find(name);
        if (material == materials_->end()) material = materials_->find(name = without_comment(name));
        const bool is_known = material != materials_->end();
        if (!is_known && !name.empty()) report_.warn("material is in no library", name);
        if (materials_->empty()) return;
        const MaterialId id = is_known ? material->second : MaterialId();
        const auto [slot, is_new] = slot_of_.try_emplace(id, static_cast<std::uint16_t>(cage_.materials.size()));
        if (is_new && cage_.materials.size() > kMaxSlot) {
            report_.warn("more than 65536 materials", name);
            slot_of_.erase(slot);
            return;
        }
        if (is_new) cage_.materials.push_back(id);
        slot_ = slot->second;
    }

    static constexpr std::size_t kMaxSlot = 0xffff;
    Polygons& polygons_;
    Cage& cage_;
    const std::map<std::string, MaterialId>* materials_;
    Report& report_;
    std::unordered_map<MaterialId, std::uint16_t> slot_of_;
    std::optional<std::uint16_t> slot_;
    bool names_materials_ = false;
    std::size_t before_first_uv_ = 0, before_first_normal_ = 0;  ///< how many indices count back too far
};

// The library gives 0 for numbers that are not finite, which the importer reports as such in files of other kinds.
void put_not_finite(const ObjStatements& statements, Polygons& polygons)
{
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (const std::size_t v : statements.positions_not_finite) polygons.cage.positions.at(v) = Vec3f(kNan);
    for (const std::size_t n : statements.normals_not_finite) polygons.normals.at(n) = Vec3f(kNan);
    for (const std::size_t t : statements.uvs_not_finite) polygons.cage.uv_sets.at(0).values.at(t) = Vec2f(kNan);
}

}  // namespace

Polygons read_obj(const std::filesystem::path& file, Scene& scene, bool with_materials, Report& report)
{
    std::string text = read_text(file);
    Polygons polygons;
    polygons.cage.name = file.stem().string();
    ObjStatements statements = scan_obj_statements(text, polygons.cage, report);
    polygons.is_tagged = statements.is_tagged;
    polygons.has_libraries = !statements.material_libraries.empty();
    polygons.smoothing = statements.smoothing;
    polygons.far = std::move(statements.far);
    std::optional<std::map<std::string, MaterialId>> materials;
    if (with_materials) materials = read_mtl(statements.material_libraries, scene, report);

    Collector collector(polygons, statements, materials ? &*materials : nullptr, report);
    TextStream stream(text);
    std::string warnings, errors;
    const bool ok = tinyobj::LoadObjWithCallback(stream, collector.callbacks(), &collector, nullptr, &warnings, &errors);
    if (!ok || !errors.empty()) throw Error(report.name(), "not a readable OBJ: " + errors);
    put_not_finite(statements, polygons);
    collector.finish();
    if (with_materials && collector.names_materials() && statements.material_libraries.empty())
        scene.notes.emplace_back("the file names materials but no library: the default material is used");
    if (!polygons.smoothing.empty()) polygons.smoothing.resize(polygons.cage.face_sizes.size(), polygons.smoothing.back());
    return polygons;
}

Scene load_obj(const std::filesystem::path& file, const LoadOptions& options)
{
    Scene scene;
    Report report(file, options.strict);
    Polygons polygons = read_obj(file, scene, true, report);
    place_far(polygons);
    add_settled(scene, settle(std::move(polygons), options.subdivide, report));
    finish(scene, report);
    return scene;
}

}  // namespace occam::import

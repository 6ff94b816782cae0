#include "io/import/polygons.h"

#include <algorithm>
#include <optional>

#include "io/import/key_numbers.h"
#include "io/import/polygon_files.h"
#include "io/import/same_triangles.h"

namespace occam::import {

namespace {

// Makes one vertex of each pair of position and normal. The first pair of a position keeps the position's own index.
class VertexSplitter {
public:
    explicit VertexSplitter(std::size_t vertices) : normal_of_(vertices, kUnset), source_(vertices)
    {
        for (std::size_t v = 0; v < vertices; ++v) source_[v] = static_cast<std::uint32_t>(v);
    }
    std::uint32_t vertex(std::uint32_t position, std::uint32_t normal)
    {
        if (position >= positions()) return kNoIndex;
        if (normal_of_[position] == kUnset) normal_of_[position] = normal;
        if (normal_of_[position] == normal) return position;
        const auto first_copy = static_cast<std::uint32_t>(positions());
        const std::uint32_t vertex = first_copy + copies_.number_of({position, normal});
        if (vertex == source_.size()) {
            normal_of_.push_back(normal);
            source_.push_back(position);
        }
        return vertex;
    }
    template <class T>
    void spread(std::vector<T>& values) const
    {
        if (values.empty()) return;
        const std::size_t old_size = values.size();
        values.resize(source_.size());
        for (std::size_t v = old_size; v < source_.size(); ++v) values[v] = values[source_[v]];
    }
    const std::vector<std::uint32_t>& normal_of() const { return normal_of_; }

private:
    std::size_t positions() const { return source_.size() - copies_.size(); }

    static constexpr std::uint32_t kUnset = 0xfffffffe;
    std::vector<std::uint32_t> normal_of_, source_;
    KeyNumbers<2> copies_;  // those that do not keep the position's index, which come after all that do
};

void split_by_normal(Polygons& polygons)
{
    Cage& cage = polygons.cage;
    VertexSplitter splitter(cage.positions.size());
    for (std::size_t c = 0; c < cage.face_vertices.size(); ++c)
        cage.face_vertices[c] = splitter.vertex(cage.face_vertices[c], polygons.normal_indices[c]);
    splitter.spread(cage.positions);
    if (cage.color_indices.empty()) splitter.spread(cage.colors);
    for (UvSet& set : cage.uv_sets)
        if (set.indices.empty()) splitter.spread(set.values);
    cage.normals.resize(cage.positions.size());
    for (std::size_t v = 0; v < cage.normals.size(); ++v) {
        const std::uint32_t n = splitter.normal_of()[v];
        cage.normals[v] = n < polygons.normals.size() ? polygons.normals[n] : Vec3f(0);  // sanitize() makes one
    }
}

// Corners without coordinates share one value at the end.
void fill_missing_uvs(Cage& cage)
{
    for (UvSet& set : cage.uv_sets) {
        const std::uint32_t spare = static_cast<std::uint32_t>(set.values.size());
        bool is_used = false;
        for (std::uint32_t& i : set.indices)
            if (i == kNoIndex) i = spare, is_used = true;
        if (is_used) set.values.push_back(Vec2f(0));
    }
}

// Returns the scheme that the cage's name asks for; none means Loop's scheme, which is not supported.
std::optional<Scheme> scheme_of_name(const std::string& name)
{
    if (name.starts_with("loop_")) return std::nullopt;
    return name.starts_with("bilinear_") ? Scheme::Bilinear : Scheme::CatmullClark;
}

std::string note_of_cage(const Polygons& polygons, Subdivide subdivide)
{
    const char* surface = polygons.cage.scheme == Scheme::Bilinear ? "a bilinear surface" : "a Catmull-Clark surface";
    return std::to_string(polygons.cage.face_sizes.size()) + " faces are the cage of " + surface +
           (subdivide == Subdivide::On ? " (--subdivide on)"
                                       : " (the file has subdivision tags; --subdivide off renders the faces themselves)");
}

// Returns an empty line for triangles without tags, since they leave no choice.
std::string note_of_faces(const Polygons& polygons, Subdivide subdivide)
{
    const std::vector<std::uint32_t>& sizes = polygons.cage.face_sizes;
    if (!polygons.is_tagged && std::all_of(sizes.begin(), sizes.end(), [](std::uint32_t n) { return n <= 3; })) return {};
    const bool is_smooth = std::any_of(polygons.smoothing.begin(), polygons.smoothing.end(),
                                       [](std::uint32_t group) { return group != 0; });
    const char* normals = !polygons.normal_indices.empty() ? "with the file's normals"
                          : is_smooth                      ? "smooth in the file's smoothing groups"
                                                           : "flat, since the file has no normals";
    return std::to_string(polygons.cage.face_sizes.size()) + " faces are rendered as they are, " + normals +
           (subdivide == Subdivide::Off ? " (--subdivide off)" : " (--subdivide on makes a Catmull-Clark surface of them)");
}

const char* fault_of(CutPolygon result)
{
    switch (result) {
        case CutPolygon::Whole:
            break;
        case CutPolygon::Crossing:
            return "a face crosses itself or is far from flat: its triangles may leave it";
        case CutPolygon::AsConvex:
            return "a concave face of more than 512 corners is cut as if it were convex";
        case CutPolygon::WithoutEars:
            return "a concave face is cut as if it were convex, since those before it have too many corners in all";
    }
    return nullptr;
}

void warn_of_cut(CutPolygon result, std::size_t face, Report& report)
{
    if (const char* fault = fault_of(result)) report.warn(fault, "face " + std::to_string(face));
}

}  // namespace

Cage triangulate(Polygons polygons, Report& report)
{
    complete_normals(polygons);
    if (!polygons.normal_indices.empty()) split_by_normal(polygons);
    Cage& in = polygons.cage;
    Cage out = std::move(in);
    const std::vector<std::uint32_t> sizes = std::move(out.face_sizes), vertices = std::move(out.face_vertices),
                                     holes = std::move(out.holes), colors = std::move(out.color_indices);
    const std::vector<std::uint16_t> slots = std::move(out.face_slots);
    std::vector<std::vector<std::uint32_t>> uv_indices;
    for (UvSet& set : out.uv_sets) uv_indices.push_back(std::move(set.indices));
    out.face_sizes.clear(), out.face_vertices.clear(), out.holes.clear(), out.face_slots.clear();
    for (UvSet& set : out.uv_sets) set.indices.clear();
    out.creases.clear(), out.corners.clear(), out.color_indices.clear();
    out.scheme = Scheme::Triangles;

    std::vector<bool> is_hole(sizes.size(), false);
    for (std::uint32_t hole : holes)
        if (hole < is_hole.size()) is_hole[hole] = true;
    EarBudget ears = EarBudget::of_file(vertices.size());
    std::vector<Vec3f> corners;
    std::vector<std::uint32_t> cut;
    out.face_vertices.reserve(vertices.size() * 3 / 2);
    for (std::size_t f = 0, begin = 0; f < sizes.size(); begin += sizes[f++]) {
        if (is_hole[f] || sizes[f] < 3) continue;
        corners.clear(), cut.clear();
        for (std::uint32_t c = 0; c < sizes[f]; ++c) {
            const std::uint32_t v = vertices[begin + c];
            corners.push_back(v < out.positions.size() ? out.positions[v] : Vec3f(0));
        }
        warn_of_cut(cut_polygon(corners, ears, cut), f, report);
        for (std::uint32_t c : cut) {
            out.face_vertices.push_back(vertices[begin + c]);
            for (std::size_t s = 0; s < uv_indices.size(); ++s)
                if (!uv_indices[s].empty()) out.uv_sets[s].indices.push_back(uv_indices[s][begin + c]);
            if (!colors.empty()) out.color_indices.push_back(colors[begin + c]);
        }
        if (!slots.empty()) out.face_slots.insert(out.face_slots.end(), cut.size() / 3, slots[f]);
    }
    fill_missing_uvs(out);
    drop_same_triangles(out, report);
    check_boxes(out, report);
    return out;
}

void place_far(Polygons& polygons)
{
    const Vec3d middle = polygons.far.move(polygons.cage.positions);
    if (middle != Vec3d(0)) polygons.place = middle;
}

Settled settle(Polygons polygons, Subdivide subdivide, Report& report)
{
    if (polygons.far.loses_shape())
        report.warn(
            "the vertices are so far from the origin, compared with the distances between them, that these are rounded",
            report.name());
    const Vec3d place = polygons.place;
    constexpr const char* kLoop = "its name says that it is a cage of the Loop scheme, which is not supported";
    bool is_cage = subdivide == Subdivide::On || (subdivide == Subdivide::Auto && polygons.is_tagged);
    const std::optional<Scheme> scheme = scheme_of_name(polygons.cage.name);
    if (is_cage && !scheme) {
        if (subdivide == Subdivide::On) throw Error(report.name(), kLoop, "--subdivide off renders its triangles");
        report.warn(std::string(kLoop) + ": its triangles are rendered as they are", polygons.cage.name);
        is_cage = false;
    }
    if (!is_cage) {
        std::string note = note_of_faces(polygons, subdivide);
        return {triangulate(std::move(polygons), report), std::move(note), place};
    }
    polygons.cage.scheme = *scheme;
    fill_missing_uvs(polygons.cage);
    std::string note = note_of_cage(polygons, subdivide);
    return {std::move(polygons.cage), std::move(note), place};
}

void add_settled(Scene& scene, Settled settled)
{
    const std::string name = settled.cage.name;
    if (!settled.note.empty()) scene.notes.push_back(name + ": " + settled.note);
    const CageId id = scene.add(std::move(settled.cage));
    scene.add_node(scene.root(), {.name = name, .place = {.translation = settled.place}, .cages = {id}});
}

Scene scene_of(Polygons polygons, const LoadOptions& options, Report& report)
{
    if (polygons.cage.face_sizes.empty()) throw Error(report.name(), "there is no face in it");
    Scene scene;
    polygons.cage.name = report.file().stem().string();
    place_far(polygons);
    add_settled(scene, settle(std::move(polygons), options.subdivide, report));
    finish(scene, report);
    return scene;
}

}  // namespace occam::import

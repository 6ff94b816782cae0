// The importer of OFF (Geomview's object file format), ASCII, with its prefixes for texture coordinates, colours and
// normals.
#include "io/import/files.h"
#include "io/import/polygon_files.h"
#include "io/import/text_cursor.h"

namespace occam::import {

namespace {

class OffReader {
public:
    OffReader(std::string_view text, Report& report) : report_(report), cursor_(text, '#') {}

    Polygons read()
    {
        read_header();
        const std::size_t vertices = count("vertices"), faces = count("faces");
        cursor_.number();  // the number of edges is often wrong, and is not needed
        // Three numbers take at least six bytes, and a face of one corner four: this is checked before anything is
        // allocated.
        if (vertices > cursor_.left() / 6 || faces > cursor_.left() / 4) refuse("declares more than the file holds");
        for (std::size_t v = 0; v < vertices; ++v) read_vertex();
        for (std::size_t f = 0; f < faces; ++f) read_face();
        if (has_normals_) polygons_.normal_indices = polygons_.cage.face_vertices;
        return std::move(polygons_);
    }

private:
    [[noreturn]] void refuse(const std::string& what)
    {
        throw Error(report_.name(), what, "line " + std::to_string(cursor_.line()));
    }

    void read_header()
    {
        std::string_view word = cursor_.word();
        const auto take = [&](std::string_view prefix) {
            const bool has = word.starts_with(prefix);
            if (has) word.remove_prefix(prefix.size());
            return has;
        };
        has_uvs_ = take("ST");
        has_colors_ = take("C");
        has_normals_ = take("N");
        if (word != "OFF") refuse("does not begin with OFF, or is of a kind that is not read");
        if (has_uvs_) polygons_.cage.uv_sets.resize(1);
    }
    std::size_t count(const char* what)
    {
        const auto n = cursor_.number();
        if (!n || !(*n >= 0 && *n < 4294967295.0)) refuse(std::string("the number of ") + what + " is missing");
        return static_cast<std::size_t>(*n);
    }
    float number()
    {
        const auto n = cursor_.number();
        if (!n) refuse("a number is missing");
        return static_cast<float>(*n);
    }
    Vec3f vector()
    {
        const float x = number(), y = number();
        return {x, y, number()};
    }
    void read_vertex()
    {
        polygons_.cage.positions.push_back(vector());
        if (has_normals_) polygons_.normals.push_back(vector());
        if (has_colors_) {
            const Vec3f rgb = vector();
            polygons_.cage.colors.emplace_back(rgb, number());
        }
        if (has_uvs_) {
            const float u = number();
            polygons_.cage.uv_sets[0].values.emplace_back(u, 1 - number());
        }
    }
    void read_face()
    {
        const std::size_t size = count("corners");
        if (size > cursor_.left()) refuse("a face is longer than the file");
        if (size < 3) report_.warn("points and lines are not rendered");
        else polygons_.cage.face_sizes.push_back(static_cast<std::uint32_t>(size));
        for (std::size_t c = 0; c < size; ++c) {
            const auto index = cursor_.number();
            if (!index) refuse("an index is missing");
            const bool is_index = *index >= 0 && *index < 4294967295.0;
            if (size >= 3) polygons_.cage.face_vertices.push_back(is_index ? static_cast<std::uint32_t>(*index) : kNoIndex);
        }
        cursor_.skip_line();  // the face's own colour
    }

    Report& report_;
    TextCursor cursor_;
    bool has_uvs_ = false, has_colors_ = false, has_normals_ = false;
    Polygons polygons_;
};

}  // namespace

Scene load_off(const std::filesystem::path& file, const LoadOptions& options)
{
    Report report(file, options.strict);
    const std::string text = read_file(file);
    return scene_of(OffReader(text, report).read(), options, report);
}

}  // namespace occam::import

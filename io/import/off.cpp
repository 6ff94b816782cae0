// The importer of OFF (Geomview's object file format), ASCII, with its prefixes for texture coordinates, colours and
// normals, and with colours of faces.
#include <algorithm>
#include <array>
#include <cmath>

#include "io/import/file_colors.h"
#include "io/import/files.h"
#include "io/import/polygon_files.h"
#include "io/import/text_cursor.h"

namespace occam::import {

namespace {

// Collects the colours of vertices or faces as they are written. Colours without a decimal point are bytes, but many files
// mean 0 and 1 by such numbers: they are bytes only if one of them is above 1.
class OffColors {
public:
    /// Adds a colour of three or four numbers; returns false, and adds none, if they are something else.
    bool add(std::span<const std::string_view> words)
    {
        Vec4f color(0, 0, 0, kNoAlpha);
        bool is_whole = true;
        for (std::size_t k = 0; k < words.size(); ++k) {
            const auto value = TextCursor(words[k]).number();
            if (!value) return false;
            color[static_cast<int>(k)] = static_cast<float>(*value);
            is_whole &= words[k].find_first_not_of("+-0123456789") == std::string_view::npos;
        }
        if (is_whole) are_bytes_ |= std::max({color.x, color.y, color.z, color.w}) > 1;
        colors_.push_back(color);
        is_whole_.push_back(is_whole);
        return true;
    }
    void add_white() { colors_.emplace_back(1), is_whole_.push_back(false); }

    /// Returns linear colours. Bytes are sRGB.
    std::vector<Vec4f> take(Report& report)
    {
        for (std::size_t i = 0; i < colors_.size(); ++i) {
            Vec4f& color = colors_[i];
            if (is_whole_[i] && are_bytes_)
                color = linear_color(Vec4f(Vec3f(color) / 255.0f, color.w == kNoAlpha ? 1 : color.w / 255));
            else if (color.w == kNoAlpha) color.w = 1;
        }
        clamp_colors(colors_, report);
        return std::move(colors_);
    }

private:
    static constexpr float kNoAlpha = -3e38f;  // no file means it
    std::vector<Vec4f> colors_;
    std::vector<bool> is_whole_;
    bool are_bytes_ = false;
};

class OffReader {
public:
    OffReader(std::string_view text, Report& report) : report_(report), cursor_(text, '#') {}

    Polygons read()
    {
        read_header();
        const std::size_t vertices = count("vertices"), faces = count("faces");
        skip_edges();
        // Three numbers take at least six bytes, and a face of one corner four: this is checked before anything is
        // allocated.
        if (vertices > cursor_.left() / 6 || faces > cursor_.left() / 4) refuse("declares more than the file holds");
        parts_of_color_ = vertices > 1 && lacks_alpha() ? 3 : 4;
        for (std::size_t v = 0; v < vertices; ++v) read_vertex();
        polygons_.cage.colors = vertex_colors_.take(report_);
        for (std::size_t f = 0; f < faces; ++f) read_face();
        if (has_face_colors_) set_face_colors(polygons_, face_colors_.take(report_), report_);
        if (!cursor_.is_at_end()) report_.warn("the file goes on after the faces that it declares");
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
    // Files with an alpha less, as some programs write, have a vertex a line: the first two lines tell.
    bool lacks_alpha() const
    {
        TextCursor ahead = cursor_;
        const std::size_t words = std::size_t(6) + (has_normals_ ? 3 : 0) + (has_uvs_ ? 2 : 0);
        return has_colors_ && !ahead.is_at_end() && ahead.rest_of_line({}) == words && !ahead.is_at_end() &&
               ahead.rest_of_line({}) == words;
    }
    std::size_t count(const char* what)
    {
        const auto n = cursor_.number();
        if (!n || !(*n >= 0 && *n < 4294967295.0)) refuse(std::string("the number of ") + what + " is missing");
        if (*n != std::floor(*n)) refuse(std::string("the number of ") + what + " is not a whole number");
        return static_cast<std::size_t>(*n);
    }
    // The number of edges is often wrong, and is not needed. Some programs leave it out: then the line ends before it, and
    // the next one has more than a number.
    void skip_edges()
    {
        TextCursor ahead = cursor_;
        bool is_there = ahead.rest_of_line({}) > 0;
        if (!is_there && !ahead.is_at_end()) is_there = ahead.rest_of_line({}) == 1;
        if (is_there) cursor_.number();
    }
    double exact_number()
    {
        const auto n = cursor_.number();
        if (!n) refuse(cursor_.why_no_number());
        return *n;
    }
    float number() { return static_cast<float>(exact_number()); }
    Vec3d vector()
    {
        const double x = exact_number(), y = exact_number();
        return {x, y, exact_number()};
    }
    void read_vertex()
    {
        const Vec3d position = vector();
        polygons_.cage.positions.emplace_back(position);
        polygons_.far.add(position);
        if (has_normals_) polygons_.normals.emplace_back(vector());
        if (has_colors_) {
            std::array<std::string_view, 4> words;
            for (std::size_t k = 0; k < parts_of_color_; ++k) words[k] = cursor_.word();
            if (!vertex_colors_.add(std::span(words).first(parts_of_color_))) refuse("a number is missing");
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
            if (*index != std::floor(*index)) refuse("an index of a face is not a whole number");
            const bool is_index = *index >= 0 && *index < 4294967295.0;
            if (size >= 3) polygons_.cage.face_vertices.push_back(is_index ? static_cast<std::uint32_t>(*index) : kNoIndex);
        }
        read_face_color(size >= 3);
    }
    void read_face_color(bool is_face)
    {
        std::array<std::string_view, 4> words;
        const std::size_t count = cursor_.rest_of_line(words);
        const bool may_be_color = count == 3 || count == 4;
        const bool is_color = may_be_color && is_face && face_colors_.add(std::span(words).first(count));
        if (count == 1) report_.warn("colours of faces that are numbers in a colour map are not read");
        else if (count > 0 && !is_color && (is_face || !may_be_color))
            report_.warn("what follows the corners of a face is not a colour");
        has_face_colors_ |= is_color;
        if (is_face && !is_color) face_colors_.add_white();
    }

    Report& report_;
    TextCursor cursor_;
    bool has_uvs_ = false, has_colors_ = false, has_normals_ = false, has_face_colors_ = false;
    std::size_t parts_of_color_ = 4;
    OffColors vertex_colors_, face_colors_;
    Polygons polygons_;
};

}  // namespace

Scene load_off(const std::filesystem::path& file, const LoadOptions& options)
{
    Report report(file, options.strict);
    const std::string text = read_text(file);
    return scene_of(OffReader(text, report).read(), options, report);
}

}  // namespace occam::import

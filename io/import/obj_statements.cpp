#include "io/import/obj_statements.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include "base/number_in.h"
#include "base/srgb.h"
#include "io/import/obj_lines.h"

namespace occam::import {

namespace {

struct Tag {
    std::string_view name;
    std::vector<std::uint32_t> ints;
    std::vector<float> floats;
};

std::optional<Tag> parse_tag(Words words)
{
    Tag tag{words.next(), {}, {}};
    unsigned counts[3] = {};
    const std::string_view sizes = words.next();
    const char *at = sizes.data(), *end = sizes.data() + sizes.size();
    for (int i = 0; i < 3; ++i) {
        const auto [after, error] = std::from_chars(at, end, counts[i]);
        if (error != std::errc() || (i < 2 && (after == end || *after != '/'))) return std::nullopt;
        at = after + 1;
    }
    for (unsigned i = 0; i < counts[0]; ++i) {
        const auto value = words.number<std::int64_t>();
        if (!value || *value < 0 || *value > 0x7fffffff) return std::nullopt;
        tag.ints.push_back(static_cast<std::uint32_t>(*value));
    }
    for (unsigned i = 0; i < counts[1]; ++i) {
        const auto value = words.number<float>();
        if (!value) return std::nullopt;
        tag.floats.push_back(*value);
    }
    return tag;
}

// Returns false if the tag says nothing that the importer understands.
bool apply_tag(const Tag& tag, Cage& cage)
{
    // A tag gives one sharpness for all elements, or one for each.
    const auto sharpness = [&](std::size_t i) { return tag.floats[tag.floats.size() == 1 ? 0 : i]; };
    const auto has_sharpness = [&](std::size_t elements) { return tag.floats.size() == 1 || tag.floats.size() >= elements; };
    if (tag.name == "crease" && tag.ints.size() >= 2 && has_sharpness(tag.ints.size() / 2)) {
        for (std::size_t i = 0; i + 1 < tag.ints.size(); i += 2)
            cage.creases.push_back({tag.ints[i], tag.ints[i + 1], sharpness(i / 2)});
        return true;
    }
    if (tag.name == "corner" && !tag.ints.empty() && has_sharpness(tag.ints.size())) {
        for (std::size_t i = 0; i < tag.ints.size(); ++i) cage.corners.push_back({tag.ints[i], sharpness(i)});
        return true;
    }
    if (tag.name == "hole" && !tag.ints.empty()) {
        cage.holes.insert(cage.holes.end(), tag.ints.begin(), tag.ints.end());
        return true;
    }
    if (tag.name == "interpolateboundary" && tag.ints.size() == 1 && tag.ints[0] <= 2) {
        constexpr BoundaryRule kBoundaryRules[] = {BoundaryRule::None, BoundaryRule::EdgeAndCorner, BoundaryRule::EdgeOnly};
        cage.boundary = kBoundaryRules[tag.ints[0]];
        return true;
    }
    return false;
}

// Holds the colours that some programs write after a vertex's position: sRGB from 0 to 1. A vertex that lacks them is
// white, be it before the first that has them or after it. A vertex of four numbers before any colour ends with a weight,
// and then no vertex has colours.
class VertexColors {
public:
    explicit VertexColors(std::vector<Vec4f>& colors) : colors_(colors) {}

    /// Adds what follows the position of the next vertex.
    void add(std::string_view rest)
    {
        ++vertices_;
        if (has_weights_) return;
        Words words(rest);
        const auto r = words.number<float>(), g = words.number<float>(), b = words.number<float>();
        const bool is_color = r && g && b;
        if (!is_color && colors_.empty()) {
            has_weights_ = r && !g;
            return;
        }
        colors_.resize(vertices_ - 1, Vec4f(1));
        const auto linear = [&](float s) {
            are_in_range &= s >= 0 && s <= 1;
            return linear_from_srgb(std::clamp(s, 0.0f, 1.0f));
        };
        colors_.push_back(is_color ? Vec4f(linear(*r), linear(*g), linear(*b), 1) : Vec4f(1));
    }
    bool are_in_range = true;

private:
    std::vector<Vec4f>& colors_;
    std::size_t vertices_ = 0;
    bool has_weights_ = false;
};

// Holds the smoothing groups of faces, which stand on separate lines before them. A group is a number; 0 and `off` are flat,
// and `on` is group 1.
class SmoothingGroups {
public:
    void set(std::string_view word)
    {
        group_ = number_in<std::uint32_t>(word).value_or(word == "on" ? 1 : 0);
        is_used_ |= group_ != 0;
    }
    void add_face()
    {
        ++faces_;
        if (!is_used_) return;
        groups_.resize(faces_ - 1, 0);  // faces before the first group are flat
        groups_.push_back(group_);
    }
    std::vector<std::uint32_t> take() { return std::move(groups_); }

private:
    std::vector<std::uint32_t> groups_;
    std::size_t faces_ = 0;
    std::uint32_t group_ = 0;
    bool is_used_ = false;
};

// Counts elements, and refuses those with numbers that the library would take for others.
class ElementCounter {
public:
    ElementCounter(const ObjLines& lines, ObjStatements& found, Report& report)
        : lines_(lines), found_(found), report_(report)
    {
    }

    // Returns what follows the position of a vertex; none for other elements.
    std::optional<std::string_view> vertex(std::string_view line)
    {
        const char kind = line.size() > 1 ? line[1] : ' ';
        if (is_blank(kind)) {
            std::string_view rest = line.substr(1);
            check(rest, 3, found_.positions++, found_.positions_not_finite);
            const std::string_view after = rest;
            if (found_.far.needs_more()) add_exactly(line.substr(1));
            while (true) {
                const NumberKind more = take_number(rest);
                if (more == NumberKind::Missing) return after;
                if (more == NumberKind::Malformed) report_.warn("words after a vertex's position are no numbers", where());
            }
        }
        if (line.size() == 2 || is_blank(line[2])) {
            std::string_view rest = line.substr(2);
            if (kind == 'n') check(rest, 3, found_.normals++, found_.normals_not_finite);
            if (kind == 't') check(rest, 1, found_.uvs++, found_.uvs_not_finite);
        }
        return std::nullopt;
    }
    // Returns true if the library counts it: a line without a corner is not a face.
    bool face(std::string_view line)
    {
        if (line.size() > 1 && !is_blank(line[1])) return false;
        const std::optional<std::size_t> corners = count_corners(lines_.place().subspan(1));
        if (!corners) throw Error(report_.name(), "an index of a face is not a whole number", where());
        if (*corners < 3) report_.warn("a face of fewer than three corners is left out", where());
        found_.corners += *corners;
        found_.faces += *corners > 0;
        return *corners > 0;
    }

private:
    std::string where() const { return "line " + std::to_string(lines_.number()); }

    void add_exactly(std::string_view numbers)
    {
        Words words(numbers);
        Vec3d position(0);
        for (int k = 0; k < 3; ++k) {
            std::string_view word = words.next();
            if (word.starts_with('+')) word.remove_prefix(1);
            position[k] = number_in<double>(word).value_or(std::numeric_limits<double>::quiet_NaN());
        }
        found_.far.add(position);
        const bool is_known = std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z);
        const bool is_not_finite = !found_.positions_not_finite.empty() &&
                                   found_.positions_not_finite.back() + 1 == found_.positions;
        if (!is_known && !is_not_finite) found_.far.drop();
    }

    // needed   how many numbers may not be left out; of texture coordinates the second may
    void check(std::string_view& rest, int needed, std::size_t element, std::vector<std::size_t>& not_finite) const
    {
        bool is_finite = true;
        for (int i = 0; i < std::max(needed, 2); ++i) {
            const NumberKind kind = take_number(rest);
            if (kind == NumberKind::Missing && i < needed) throw Error(report_.name(), "a number is missing", where());
            if (kind == NumberKind::Malformed) throw Error(report_.name(), "a number is malformed", where());
            is_finite &= kind != NumberKind::NotFinite;
        }
        if (!is_finite) not_finite.push_back(element);
    }

    const ObjLines& lines_;
    ObjStatements& found_;
    Report& report_;
};

// Returns true for statements that change no picture of polygons: groups and materials, which others read, free-form
// geometry, of which the curves and surfaces are reported, and how other programs show the model.
bool changes_nothing(std::string_view keyword)
{
    constexpr std::string_view kKnown[] = {
        "g",    "o",     "mg",   "usemtl",   "vp",       "cstype", "deg",   "bmat",       "step",     "parm",
        "trim", "hole",  "scrv", "sp",       "end",      "con",    "cdc",   "cdp",        "bzp",      "bsp",
        "res",  "bevel", "lod",  "c_interp", "d_interp", "ctech",  "stech", "shadow_obj", "trace_obj"};
    return std::find(std::begin(kKnown), std::end(kKnown), keyword) != std::end(kKnown);
}

}  // namespace

ObjStatements scan_obj_statements(std::string& text, Cage& cage, Report& report)
{
    ObjStatements found;
    VertexColors colors(cage.colors);
    SmoothingGroups smoothing;
    ObjLines lines(text);
    ElementCounter elements(lines, found, report);
    while (lines.next()) {
        std::string_view line = lines.line();
        // Nearly every line is a vertex or a face.
        if (line.starts_with("#MRGB ")) report.warn("colours in comments, as ZBrush writes them (#MRGB), are not read");
        if (line.empty() || line[0] == '#') continue;
        const auto is = [&](std::string_view keyword) {
            return line.starts_with(keyword) && (line.size() == keyword.size() || is_blank(line[keyword.size()]));
        };
        if (is("v") || is("vn") || is("vt")) {
            if (const auto rest = elements.vertex(line)) colors.add(*rest);
            continue;
        }
        if (is("f")) {
            if (elements.face(line)) smoothing.add_face();
            continue;
        }
        Words words(line);
        const std::string_view keyword = words.next();
        const auto where = [&] { return "line " + std::to_string(lines.number()); };
        if (keyword == "s") {
            smoothing.set(words.next());
        } else if (keyword == "t") {
            const std::optional<Tag> tag = parse_tag(words);
            if (tag && apply_tag(*tag, cage)) found.is_tagged = true;
            else report.warn("subdivision tag not understood: it is left out", where());
        } else if (keyword == "mtllib") {
            line.remove_prefix(std::min(line.size(), line.find_first_not_of(" \t", keyword.size())));
            line = line.substr(0, line.find_last_not_of(" \t\r") + 1);
            if (!line.empty()) found.material_libraries.emplace_back(line);
        } else if (keyword == "l" || keyword == "p") {
            report.warn("points and lines are not rendered", where());
        } else if (keyword == "curv" || keyword == "curv2" || keyword == "surf") {
            report.warn("free-form curves and surfaces are not rendered", where());
        } else if (!keyword.empty() && !changes_nothing(keyword)) {
            report.warn("statement '" + std::string(keyword.substr(0, 32)) + "' is not read", where());
        }
    }
    if (!colors.are_in_range) report.warn("colours are not between 0 and 1, and become the nearest that are", "");
    found.smoothing = smoothing.take();
    return found;
}

}  // namespace occam::import

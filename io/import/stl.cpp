// The importer of STL (3D Systems, 1988), ASCII and binary. Facets share nothing in the file, so equal positions are joined.
#include <bit>
#include <cstring>

#include "io/import/files.h"
#include "io/import/polygon_files.h"
#include "io/import/text_cursor.h"
#include "io/import/vertices.h"

namespace occam::import {

namespace {

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

std::uint32_t u32(std::string_view bytes, std::size_t at)
{
    std::uint32_t x = 0;
    for (std::size_t i = 4; i-- > 0;) x = x << 8 | static_cast<unsigned char>(bytes[at + i]);
    return x;
}

// Some binary files begin with "solid", too. A byte of 0 in the header or in the number of facets tells them from a text,
// and where there is none, the length does.
bool is_binary(std::string_view bytes, const Report& report)
{
    if (bytes.size() < kHeaderBytes) return false;
    const bool begins_as_text = without_mark(bytes).starts_with("solid");
    const bool has_zero = bytes.substr(0, kHeaderBytes).find('\0') != std::string_view::npos;
    const std::size_t facets = u32(bytes, 80);
    if ((bytes.size() - kHeaderBytes) / kFacetBytes < facets) {
        if (begins_as_text && has_zero) throw Error(report.name(), "a binary STL that is cut off");
        return false;
    }
    return !begins_as_text || has_zero || bytes.size() == kHeaderBytes + kFacetBytes * facets;
}

void add_facet(Polygons& polygons, const Vec3f (&corners)[3])
{
    const std::uint32_t first = static_cast<std::uint32_t>(polygons.cage.positions.size());
    polygons.cage.positions.insert(polygons.cage.positions.end(), corners, corners + 3);
    polygons.cage.face_vertices.insert(polygons.cage.face_vertices.end(), {first, first + 1, first + 2});
    polygons.cage.face_sizes.push_back(3);
}

Polygons read_binary(std::string_view bytes, Report& report)
{
    Polygons polygons;
    const std::size_t facets = u32(bytes, 80);
    if (bytes.size() > kHeaderBytes + kFacetBytes * facets)
        report.warn("the file goes on after the facets that it declares");
    for (std::size_t f = 0; f < facets; ++f) {
        Vec3f corners[3];
        for (int c = 0; c < 3; ++c)
            for (int k = 0; k < 3; ++k)
                corners[c][k] = std::bit_cast<float>(
                    u32(bytes, kHeaderBytes + f * kFacetBytes + 12 + static_cast<std::size_t>(c * 12 + k * 4)));
        add_facet(polygons, corners);
    }
    return polygons;
}

// Returns the next keyword. Some programs write them in capitals.
std::string keyword(TextCursor& cursor)
{
    std::string word(cursor.word());
    for (char& c : word)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return word;
}

// Skips the name of a solid, which is the rest of a line, unless its first facet, or that of the next solid, stands there.
void skip_name(TextCursor& cursor)
{
    TextCursor ahead = cursor;
    for (TextCursor before = ahead; !ahead.is_at_end() && ahead.line() == cursor.line(); before = ahead)
        if (keyword(ahead) == "facet") {
            TextCursor facet = ahead;
            if (keyword(facet) != "normal" || !facet.number()) continue;
            cursor = before;
            return;
        }
    cursor.skip_line();
}

Polygons read_ascii(std::string_view text, Report& report)
{
    constexpr int kClosed = 3;
    Polygons polygons;
    TextCursor cursor(text);
    if (keyword(cursor) != "solid") throw Error(report.name(), "neither a text STL nor a binary one, unless it is cut off");
    skip_name(cursor);
    Vec3f corners[3];
    Vec3d exact[3];
    int corner = kClosed;
    bool has_end = false;
    const auto refuse = [&] {
        throw Error(report.name(), cursor.is_at_end() ? "an ascii STL that is cut off" : "not a facet of three vertices",
                    "line " + std::to_string(cursor.line()));
    };
    std::string before;  // some programs write "end solid"
    for (std::string word = keyword(cursor); !word.empty(); before = std::move(word), word = keyword(cursor)) {
        const bool is_end = word == "endsolid" || (word == "solid" && before == "end");
        if (word == "facet" || word == "endloop" || word == "endfacet" || is_end) {
            if (corner != kClosed) refuse();
        }
        if (is_end || word == "solid" || word == "facet") has_end = is_end;
        if (word == "facet" && before != "end") corner = 0;
        if (is_end || word == "solid") skip_name(cursor);
        if (word != "vertex") continue;
        for (int k = 0; k < 3; ++k) {
            const auto x = cursor.number();
            if (!x && corner != kClosed && !cursor.is_at_end())
                throw Error(report.name(), cursor.why_no_number(), "line " + std::to_string(cursor.line()));
            if (!x || corner == kClosed) refuse();
            corners[corner][k] = static_cast<float>(*x);
            exact[corner][k] = *x;
        }
        if (++corner != kClosed) continue;
        add_facet(polygons, corners);
        for (const Vec3d& position : exact) polygons.far.add(position);
    }
    if (corner != kClosed) refuse();
    if (!has_end) report.warn("the text has no endsolid: it may be cut off");
    return polygons;
}

}  // namespace

Scene load_stl(const std::filesystem::path& file, const LoadOptions& options)
{
    Report report(file, options.strict);
    const std::string bytes = read_file(file);
    Polygons polygons = is_binary(bytes, report) ? read_binary(bytes, report) : read_ascii(without_mark(bytes), report);
    if (polygons.cage.positions.size() > 0x7fffffff) throw Error(report.name(), "more than 2^31 vertices");
    place_far(polygons);  // first, since weld() joins what floats round alike
    weld(polygons.cage);
    return scene_of(std::move(polygons), options, report);
}

}  // namespace occam::import

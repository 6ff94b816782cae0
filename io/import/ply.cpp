// The importer of PLY (Turk, "The PLY polygon file format", 1994): ASCII, and binary in both byte orders.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "io/import/file_colors.h"
#include "io/import/files.h"
#include "io/import/polygon_files.h"
#include "io/import/text_cursor.h"

namespace occam::import {

namespace {

enum class Number : unsigned char { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

std::size_t bytes_of(Number type)
{
    constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return kBytes[static_cast<int>(type)];
}

std::optional<Number> type_of(std::string_view word)
{
    constexpr std::array<std::pair<const char*, Number>, 16> kNames = {{{"char", Number::Int8},
                                                                        {"int8", Number::Int8},
                                                                        {"uchar", Number::UInt8},
                                                                        {"uint8", Number::UInt8},
                                                                        {"short", Number::Int16},
                                                                        {"int16", Number::Int16},
                                                                        {"ushort", Number::UInt16},
                                                                        {"uint16", Number::UInt16},
                                                                        {"int", Number::Int32},
                                                                        {"int32", Number::Int32},
                                                                        {"uint", Number::UInt32},
                                                                        {"uint32", Number::UInt32},
                                                                        {"float", Number::Float32},
                                                                        {"float32", Number::Float32},
                                                                        {"double", Number::Float64},
                                                                        {"float64", Number::Float64}}};
    for (const auto& [name, type] : kNames)
        if (word == name) return type;
    return std::nullopt;
}

struct Property {
    std::string name;
    Number type = Number::Float32, count_type = Number::UInt8;
    bool is_list = false;
};
struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

// Says where a vertex property goes: an index into `Fields::values`.
enum Field { kX, kY, kZ, kNx, kNy, kNz, kU, kV, kRed, kGreen, kBlue, kAlpha, kFields };
constexpr int kIgnored = -1;

int field_of(const std::string& name)
{
    constexpr std::array<std::pair<const char*, Field>, 24> kNames = {{{"x", kX},
                                                                       {"y", kY},
                                                                       {"z", kZ},
                                                                       {"nx", kNx},
                                                                       {"ny", kNy},
                                                                       {"nz", kNz},
                                                                       {"u", kU},
                                                                       {"v", kV},
                                                                       {"s", kU},
                                                                       {"t", kV},
                                                                       {"texture_u", kU},
                                                                       {"texture_v", kV},
                                                                       {"red", kRed},
                                                                       {"green", kGreen},
                                                                       {"blue", kBlue},
                                                                       {"alpha", kAlpha},
                                                                       {"r", kRed},
                                                                       {"g", kGreen},
                                                                       {"b", kBlue},
                                                                       {"a", kAlpha},
                                                                       {"diffuse_red", kRed},
                                                                       {"diffuse_green", kGreen},
                                                                       {"diffuse_blue", kBlue},
                                                                       {"diffuse_alpha", kAlpha}}};
    for (const auto& [known, field] : kNames)
        if (name == known) return field;
    return kIgnored;
}

// Returns the value of a part of a colour that means 1: numbers with a point are from 0 to 1, and integers are bytes
// whatever their type, except those of 16 bits without a sign.
float white_of(Number type)
{
    if (type == Number::Float32 || type == Number::Float64) return 1;
    return type == Number::UInt16 ? 65535 : 255;
}

// Says where the values of an element go. Those that are no list and have a field get a place in `values`.
struct Fields {
    explicit Fields(const Element& element)
    {
        for (const Property& property : element.properties) {
            const int field = property.is_list ? kIgnored : field_of(property.name);
            of_property.push_back(field);
            if (field == kIgnored) continue;
            has[field] = true;
            white[field] = white_of(property.type);
        }
        has_colors = has[kRed] && has[kGreen] && has[kBlue];
    }
    // Integers come from scanners and painting programs and are sRGB; floats are linear.
    Vec4f color() const
    {
        const auto part = [&](Field field) { return static_cast<float>(values[field]) / white[field]; };
        const Vec4f rgba(part(kRed), part(kGreen), part(kBlue), has[kAlpha] ? part(kAlpha) : 1);
        return white[kRed] == 1 ? rgba : linear_color(rgba);
    }

    std::vector<int> of_property;
    bool has[kFields] = {}, has_colors = false;
    float white[kFields] = {};
    double values[kFields] = {};
};

class PlyReader {
public:
    PlyReader(std::string_view text, Report& report) : text_(text), report_(report), cursor_(text) {}

    Polygons read()
    {
        read_header();
        for (const Element& element : elements_) {
            if (element.properties.empty()) continue;
            check_count(element);
            if (element.name == "vertex") read_vertices(element);
            else if (element.name == "face" || element.name == "tristrips") read_faces(element);
            else skip_element(element);
        }
        const bool is_whole = is_binary_ ? text_.find_first_not_of(" \t\r\n", at_) == std::string_view::npos
                                         : cursor_.is_at_end();
        if (!is_whole) report_.warn("the file goes on after the elements that it declares");
        if (!polygons_.normals.empty()) polygons_.normal_indices = polygons_.cage.face_vertices;
        clamp_colors(polygons_.cage.colors, report_);
        clamp_colors(face_colors_, report_);
        set_face_colors(polygons_, std::move(face_colors_), report_);
        return std::move(polygons_);
    }

private:
    [[noreturn]] void refuse(const std::string& what, const std::string& where = {}) const
    {
        throw Error(report_.name(), what, where);
    }

    // Returns where a text is read.
    std::string place() const { return is_binary_ ? std::string() : "line " + std::to_string(cursor_.line()); }

    void read_header()
    {
        if (cursor_.word() != "ply") refuse("does not begin with 'ply'");
        for (;;) {
            const std::string_view keyword = cursor_.word();
            const std::string where = "line " + std::to_string(cursor_.line());
            if (keyword == "end_header") break;
            if (keyword == "comment" || keyword == "obj_info") {
                std::string_view words[1];
                cursor_.rest_of_line(words);
                if (words[0] == "TextureFile") report_.warn("texture files are not read", where);
            } else if (keyword == "format") {
                const std::string_view format = cursor_.word();
                is_binary_ = format != "ascii";
                is_big_endian_ = format == "binary_big_endian";
                if (is_binary_ && !is_big_endian_ && format != "binary_little_endian") refuse("unknown format", where);
                cursor_.word();
            } else if (keyword == "element") {
                Element element;
                element.name = cursor_.word();
                const auto count = cursor_.number();
                if (!count || !(*count >= 0 && *count < 4294967295.0)) refuse("an element needs a count", where);
                element.count = static_cast<std::size_t>(*count);
                elements_.push_back(std::move(element));
            } else if (keyword == "property") {
                if (elements_.empty()) refuse("property without an element", where);
                elements_.back().properties.push_back(read_property(where));
            } else {
                refuse(keyword.empty() ? "the header has no end" : "unknown keyword in the header", where);
            }
            if (elements_.size() > 1000) refuse("more than 1000 elements", where);
        }
        cursor_.skip_line();
        at_ = text_.size() - cursor_.left();
        // Where lines end with CR alone, an LF after the header is the first byte of a binary body.
        const std::size_t first = std::min(text_.find_first_of("\r\n"), text_.size());
        const bool has_cr_alone = text_.substr(first, 1) == "\r" && text_.substr(first + 1, 1) != "\n";
        at_ += !has_cr_alone && text_.substr(at_).starts_with("\r\n") ? 2 : at_ < text_.size() ? 1 : 0;
    }

    Property read_property(const std::string& where)
    {
        Property property;
        std::string_view word = cursor_.word();
        property.is_list = word == "list";
        if (property.is_list) {
            const auto count = type_of(cursor_.word());
            if (!count) refuse("unknown type", where);
            property.count_type = *count;
            word = cursor_.word();
        }
        const auto type = type_of(word);
        if (!type) refuse("unknown type", where);
        property.type = *type;
        property.name = cursor_.word();
        return property;
    }

    // Before anything is allocated, this checks that the file is long enough for so many elements.
    void check_count(const Element& element) const
    {
        std::size_t least = 0;
        for (const Property& p : element.properties) least += !is_binary_ ? 2 : bytes_of(p.is_list ? p.count_type : p.type);
        const std::size_t left = is_binary_ ? text_.size() - at_ : cursor_.left();
        // The last number of a text needs no space after it.
        if (element.count > (left + 1) / least) refuse("declares more than the file holds", "element " + element.name);
    }

    double number(Number type)
    {
        if (!is_binary_) {
            const auto value = cursor_.number();
            if (!value) refuse(cursor_.why_no_number(), place());
            return *value;
        }
        const std::size_t size = bytes_of(type);
        if (text_.size() - at_ < size) refuse("ends too early");
        unsigned char bytes[8] = {};
        for (std::size_t i = 0; i < size; ++i)
            bytes[i] = static_cast<unsigned char>(text_[at_ + (is_big_endian_ ? size - 1 - i : i)]);
        at_ += size;
        const auto as = [&]<class T>(T value) {
            std::memcpy(&value, bytes, sizeof(T));
            return static_cast<double>(value);
        };
        switch (type) {
            case Number::Int8:
                return as(std::int8_t());
            case Number::UInt8:
                return as(std::uint8_t());
            case Number::Int16:
                return as(std::int16_t());
            case Number::UInt16:
                return as(std::uint16_t());
            case Number::Int32:
                return as(std::int32_t());
            case Number::UInt32:
                return as(std::uint32_t());
            case Number::Float32:
                return as(float());
            case Number::Float64:
                return as(double());
        }
        return 0;
    }

    std::size_t list_length(const Property& property)
    {
        const double count = number(property.count_type);
        const std::size_t left = is_binary_ ? text_.size() - at_ : cursor_.left();
        if (!(count >= 0) || count * double(is_binary_ ? bytes_of(property.type) : 1) > double(left))
            refuse("a list is longer than the file");
        if (count != std::floor(count)) refuse("the length of a list is not a whole number", place());
        return static_cast<std::size_t>(count);
    }

    void skip(const Property& property)
    {
        for (std::size_t i = property.is_list ? list_length(property) : 1; i > 0; --i) number(property.type);
    }
    void skip_element(const Element& element)
    {
        if (element.name == "multi_texture_vertex" && element.count > 0)
            report_.warn("texture coordinates of faces are not read");
        for (std::size_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties) skip(property);
    }

    void read_vertices(const Element& element)
    {
        if (element.count == 0) return;  // what it declares says nothing of the vertices that are there
        Cage& cage = polygons_.cage;
        Fields fields(element);
        const auto& has = fields.has;
        if (!has[kX] || !has[kY] || !has[kZ]) refuse("vertices without x, y and z");
        const bool has_normals = has[kNx] && has[kNy] && has[kNz], has_uvs = has[kU] && has[kV];
        const bool is_alike = has_normals != polygons_.normals.empty() && has_uvs != cage.uv_sets.empty() &&
                              fields.has_colors != cage.colors.empty();
        if (!cage.positions.empty() && !is_alike) refuse("elements 'vertex' with different properties");
        if (has_uvs) cage.uv_sets.resize(1);
        for (std::size_t i = 0; i < element.count; ++i) {
            for (std::size_t p = 0; p < fields.of_property.size(); ++p) read_value(element, p, fields);
            const auto f = [&](Field field) { return static_cast<float>(fields.values[field]); };
            cage.positions.emplace_back(f(kX), f(kY), f(kZ));
            polygons_.far.add({fields.values[kX], fields.values[kY], fields.values[kZ]});
            if (has_normals) polygons_.normals.emplace_back(f(kNx), f(kNy), f(kNz));
            if (has_uvs) cage.uv_sets[0].values.emplace_back(f(kU), 1 - f(kV));
            if (fields.has_colors) cage.colors.push_back(fields.color());
        }
    }
    void read_value(const Element& element, std::size_t property, Fields& fields)
    {
        const int field = fields.of_property[property];
        if (field == kIgnored) skip(element.properties[property]);
        else fields.values[field] = number(element.properties[property].type);
    }

    void read_faces(const Element& element)
    {
        Cage& cage = polygons_.cage;
        Fields fields(element);
        for (std::size_t i = 0; i < element.count; ++i) {
            const std::size_t faces = cage.face_sizes.size();
            for (std::size_t p = 0; p < element.properties.size(); ++p) {
                const std::string& name = element.properties[p].name;
                if (element.properties[p].is_list && (name == "vertex_indices" || name == "vertex_index")) {
                    read_corners(element, element.properties[p]);
                    continue;
                }
                if (name == "texcoord") report_.warn("texture coordinates of faces are not read");
                read_value(element, p, fields);
            }
            if (!fields.has_colors) continue;
            face_colors_.resize(faces, Vec4f(1));
            face_colors_.resize(cage.face_sizes.size(), fields.color());
        }
    }
    void read_corners(const Element& element, const Property& property)
    {
        corners_.clear();
        for (std::size_t c = list_length(property); c > 0; --c) {
            const double index = number(property.type);
            if (index != std::floor(index)) refuse("an index of a face is not a whole number", place());
            corners_.push_back(index >= 0 && index < 4294967295.0 ? static_cast<std::uint32_t>(index) : kNoIndex);
        }
        if (element.name == "tristrips") add_strip(corners_);
        else if (corners_.size() < 3) report_.warn("points and lines are not rendered");
        else add_face(corners_);
    }
    void add_face(std::span<const std::uint32_t> corners)
    {
        polygons_.cage.face_vertices.insert(polygons_.cage.face_vertices.end(), corners.begin(), corners.end());
        polygons_.cage.face_sizes.push_back(static_cast<std::uint32_t>(corners.size()));
    }
    // An index of -1 begins a new strip; every second triangle is reversed.
    void add_strip(const std::vector<std::uint32_t>& strip)
    {
        std::size_t begin = 0;
        for (std::size_t i = 0; i < strip.size(); ++i) {
            if (strip[i] == kNoIndex) {
                begin = i + 1;
                continue;
            }
            if (i < begin + 2) continue;
            const std::size_t odd = (i - begin) % 2;
            const std::uint32_t corners[] = {strip[i - 2 + odd], strip[i - 1 - odd], strip[i]};
            add_face(corners);
        }
    }

    std::string_view text_;
    Report& report_;
    TextCursor cursor_;
    std::size_t at_ = 0;  // position in a binary body
    bool is_binary_ = false, is_big_endian_ = false;
    std::vector<Element> elements_;
    std::vector<std::uint32_t> corners_;  // of the face that is read
    std::vector<Vec4f> face_colors_;
    Polygons polygons_;
};

}  // namespace

Scene load_ply(const std::filesystem::path& file, const LoadOptions& options)
{
    Report report(file, options.strict);
    const std::string bytes = read_text(file);
    return scene_of(PlyReader(bytes, report).read(), options, report);
}

}  // namespace occam::import

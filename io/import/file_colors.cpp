#include "io/import/file_colors.h"

#include <algorithm>
#include <glm/common.hpp>

#include "base/srgb.h"

namespace occam::import {

Vec4f linear_color(Vec4f srgb)
{
    return {linear_from_srgb(srgb.x), linear_from_srgb(srgb.y), linear_from_srgb(srgb.z), srgb.w};
}

void clamp_colors(std::vector<Vec4f>& colors, Report& report, const std::string& where)
{
    const auto is_in_range = [](Vec4f c) { return glm::clamp(c, 0.0f, 1.0f) == c; };
    if (std::all_of(colors.begin(), colors.end(), is_in_range)) return;
    report.warn("colours are not between 0 and 1, and become the nearest that are", where);
    for (Vec4f& color : colors) color = glm::clamp(color, 0.0f, 1.0f);
}

void set_face_colors(Polygons& polygons, std::vector<Vec4f> colors, Report& report)
{
    Cage& cage = polygons.cage;
    if (colors.empty()) return;
    if (!cage.colors.empty()) {
        report.warn("colours of faces are ignored, since the vertices have colours");
        return;
    }
    colors.resize(cage.face_sizes.size(), Vec4f(1));
    cage.colors = std::move(colors);
    for (std::size_t f = 0; f < cage.face_sizes.size(); ++f)
        cage.color_indices.insert(cage.color_indices.end(), cage.face_sizes[f], static_cast<std::uint32_t>(f));
}

}  // namespace occam::import

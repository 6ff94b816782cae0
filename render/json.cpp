// All JSON output of render/ but the manifests of Cryptomatte layers, which their specification asks for
// (render/cryptomatte.cpp).
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "render/compare.h"
#include "render/setting_rows.h"
#include "render/stats.h"
#include "render/version.h"

namespace occam::render {
namespace {

using Json = nlohmann::ordered_json;

std::string hexadecimal(std::uint64_t value)
{
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
    return text;
}

// Converts a number; JSON has no infinity, so null replaces it.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const Camera& camera)
{
    Json columns = Json::array();
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r) columns.push_back(camera.world_from_camera[c][r]);
    const auto& [fov, aspect, orthographic, height, radius, focus, blades] = camera.lens;  // all: a recipe is made of them
    return {{"fov", fov},     {"aspect", aspect}, {"orthographic", orthographic}, {"height", height}, {"radius", radius},
            {"focus", focus}, {"blades", blades}, {"right_up_back_eye", columns}};
}

Json json_of(const Settings& s)
{
    Json aovs = Json::array();
    for (const AovRow& row : kAovs)
        if (s.has(row.aov)) aovs.push_back(row.name);
    Json all = {{"size", {s.width, s.height}}, {"crop", {s.crop_x0, s.crop_x1, s.crop_y0, s.crop_y1}}};
    for (const SettingRow& row : kSettings)
        std::visit(
            [&]<class T>(T Settings::*member) {
                if constexpr (std::is_enum_v<T>) all[row.name] = name_of(s.*member);
                else all[row.name] = s.*member;
            },
            row.member);
    all.update({{"shutter", {s.shutter.open, s.shutter.close}},
                {"aov", aovs},
                {"default_light", s.default_light ? Json(*s.default_light) : Json(nullptr)},
                {"lod_camera", s.lod_camera ? json_of(*s.lod_camera) : Json(nullptr)}});
    return all;
}

std::string text_of(const Json& json)
{
    // Names in an untrusted file may hold bytes that are not UTF-8.
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::uint64_t process_peak_bytes() noexcept
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::string to_json(const Settings& settings) { return text_of(json_of(settings)); }

std::string to_json(const FrameStats& s)
{
    // This is one function because it is a single table.
    const auto& t = s.seconds;
    Json by_level = Json::array();
    for (const auto& [level, count] : s.built.by_level) by_level.push_back({{"level", level}, {"micropolygons", count}});
    Json workers = Json::array();
    for (const FrameStats::Worker& w : s.workers)
        workers.push_back({{"cpu_seconds", number(w.cpu_seconds)},
                           {"build_seconds", number(w.build_seconds)},
                           {"tiles", w.tiles},
                           {"kd_nodes", w.kd_nodes},
                           {"grids", w.grids},
                           {"micropolygons", w.micropolygons},
                           {"arena_peak_bytes", w.arena_peak_bytes}});
    return text_of({
        {"scene",
         {{"nodes", s.scene.nodes},
          {"cages", s.scene.cages},
          {"faces", s.scene.faces},
          {"triangles_in", s.scene.triangles_in},
          {"lights", s.scene.lights},
          {"warnings", s.scene.warnings}}},
        {"motion", {{"segments", s.motion.segments}, {"camera_segments", s.motion.camera_segments}}},
        {"seconds",
         {{"total", t.total},
          {"load", t.load},
          {"edit", t.edit},
          {"refit", t.refit},
          {"build", t.build},
          {"tessellate", t.tessellate},
          {"deform", t.deform},
          {"trace", t.trace},
          {"shade", t.shade},
          {"phase_one", t.phase_one},
          {"texture", t.texture},
          {"film", t.film},
          {"write", t.write}}},
        {"lights", {{"has_default", s.lights.has_default}, {"has_emitters", s.lights.has_emitters}}},
        {"rays",
         {{"primary", s.rays.primary},
          {"shadow", s.rays.shadow},
          {"ao", s.rays.ao},
          {"glossy", s.rays.glossy},
          {"diffuse", s.rays.diffuse},
          {"total", s.rays.total()},
          {"per_second", number(s.rays.per_second)}}},
        {"built",
         {{"kd_nodes", s.built.kd_nodes},
          {"grids", s.built.grids},
          {"micropolygons", s.built.micropolygons},
          {"faces_touched", s.built.faces_touched},
          {"vertices_deformed", s.built.vertices_deformed},
          {"vertices_shaded", s.built.vertices_shaded},
          {"vertices_looked_up", s.built.vertices_looked_up},
          {"hits_looked_up", s.built.hits_looked_up},
          {"visible_cells", number(s.built.visible_cells)},
          {"camera_quads_per_cell", number(s.built.quads_per_cell(s.built.by_camera_rays))},
          {"shadow_quads_per_cell", number(s.built.quads_per_cell(s.built.by_shadow_rays))},
          {"by_level", by_level}}},
        {"memory",
         {{"peak_bytes", s.memory.peak_bytes},
          {"arena_peak_bytes", s.memory.arena_peak_bytes},
          {"texture_bytes", s.memory.texture_bytes},
          {"flushes", s.memory.flushes},
          {"floor_bytes", s.memory.floor_bytes},
          {"queue_bytes", s.memory.queue_bytes},
          {"film_bytes", s.memory.film_bytes}}},
        {"workers", workers},
        {"image",
         {{"width", s.image.width},
          {"height", s.image.height},
          {"spp", s.image.spp},
          {"samples", s.image.samples},
          {"least_samples", s.image.least_samples},
          {"samples_not_finite", s.image.samples_not_finite},
          {"checksum", hexadecimal(s.image.checksum)}}},
        {"settings", json_of(s.settings)},
        {"complete", s.complete},
        {"warnings", s.warnings},
        {"version", kVersion},
        {"threads", s.threads},
        {"accel", s.tree == accel::TreeKind::Bvh ? "bvh" : "kd"},
    });
}

std::string to_json(const std::vector<Difference>& differences)
{
    Json all = Json::array();
    for (const Difference& d : differences)
        all.push_back({{"layer", d.layer},
                       {"pixels", d.pixels},
                       {"incomparable", d.incomparable},
                       {"same_channels", !d.has_other_channels},
                       {"mse", number(d.mse)},
                       {"rmse", number(d.rmse)},
                       {"rel_mse", number(d.rel_mse)},
                       {"psnr", number(d.psnr)},
                       {"max", number(d.max)},
                       {"p999", number(d.p999)}});
    return text_of(all);
}

}  // namespace occam::render

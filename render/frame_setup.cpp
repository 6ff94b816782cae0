#include "render/frame_setup.h"

#include "render/light_probe.h"
#include "render/shade_point.h"

namespace occam::render {
namespace {

lod::LevelMode mode_of(Lod lod) noexcept
{
    switch (lod) {
        case Lod::On:
            return lod::LevelMode::PerRay;
        case Lod::Off:
            return lod::LevelMode::PerInstance;
        case Lod::Frozen:
            return lod::LevelMode::Frozen;
    }
    return lod::LevelMode::PerRay;
}

CameraRays lod_camera_of(const Settings& settings, const FrameScale& scale)
{
    return {scale.placed(*settings.lod_camera), settings.width, settings.height};
}

// Returns the settings by which levels are chosen, which another camera's pixels may decide.
lod::LevelSettings levels_of(const Settings& settings, const FrameScale& scale, const CameraRays& camera)
{
    lod::LevelSettings levels = settings.lod_camera ? lod_camera_of(settings, scale).levels(settings.shading_rate)
                                                    : camera.levels(settings.shading_rate);
    if (settings.lod_camera) levels.eyes.clear();  // its footprints are those of mid-shutter
    levels.mode = mode_of(settings.lod);
    // A blurred surface needs no more detail than its samples can tell, unless the camera may follow it. Colours that are
    // made at vertices need all of them: along the stripes of a texture motion hides nothing.
    const bool may_be_coarse = settings.lod != Lod::Off && settings.shade_at == ShadeAt::Hit && !settings.lod_camera &&
                               !camera.moves() && levels.pixel.b > 0;
    if (may_be_coarse) levels.strata = settings.spp;
    return levels;
}

lod::VertexShading shading_of(const FrameInputs& in, const shade::PhaseOne& phase_one, const HoleFilter& holes)
{
    return {in.settings.shade_at == ShadeAt::Vertex ? &phase_one : nullptr, sample_width(in.settings.spp),
            holes.if_needed(in.scene.contents())};
}

// Sets the nearest and farthest camera z of the scene's box, which is in frame lengths.
void set_depth_range(FrameContext& context, const Box3d& bounds)
{
    if (bounds.is_empty()) return;
    double z_near = std::numeric_limits<double>::infinity(), z_far = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3d p(corner & 1 ? bounds.hi.x : bounds.lo.x, corner & 2 ? bounds.hi.y : bounds.lo.y,
                      corner & 4 ? bounds.hi.z : bounds.lo.z);
        const double z = std::max(0.0, context.camera.depth(p));
        z_near = std::min(z_near, z);
        z_far = std::max(z_far, z);
    }
    context.depth_near = static_cast<float>(z_near);
    context.depth_far = static_cast<float>(z_far);
}

}  // namespace

CameraRays camera_of(const Settings& settings, const FrameScale& scale, const Camera& camera)
{
    CameraRays rays(scale.placed(camera), settings.width, settings.height, settings.spp, settings.shading_rate);
    if (settings.lod_camera) rays.take_footprints_of(lod_camera_of(settings, scale));
    return rays;
}

FrameSetup::FrameSetup(const FrameInputs& in)
    : scale(in.scene_bounds),
      camera(camera_of(in.settings, scale, in.camera)),
      levels(levels_of(in.settings, scale, camera)),
      filter(in.settings.filter, in.settings.filter_radius),
      sampler(in.settings.seed, in.settings.spp, in.settings.jitter),
      lights(lights_of(in, scale)),
      passes(in.settings),
      context{in.settings, camera, sampler, filter, lights, in.textures, passes},
      phase_one(in.textures),
      holes(in.textures, !in.settings.back_faces),
      frame(in.scene, in.topologies, levels, {&in.textures, shading_of(in, phase_one, holes), scale, in.resources.tree})
{
    context.may_pass = in.scene.contents().has(Contents::Passing);
    context.scene = &in.scene;
    context.scale = scale;
    context.moves = camera.moves() || in.scene.shutter_segments() > 0;
    context.may_start_in_body = in.scene.contents().has(Contents::Absorbing);
    context.shadow_batch = in.memory.shadow_batch;
    set_depth_range(context, scale.placed(in.scene_bounds));
}

}  // namespace occam::render

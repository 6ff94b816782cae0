#include "render/path_log.h"

#include "accel/print.h"
#include "base/printable.h"

namespace occam::render {
namespace {

std::string_view kind_name(std::uint8_t kinds) noexcept
{
    if ((kinds & accel::RayKind::Camera) != 0) return "camera ray";
    if ((kinds & accel::RayKind::Shadow) != 0) return "shadow ray";
    if ((kinds & accel::RayKind::Diffuse) != 0) return "diffuse ray";
    return (kinds & accel::RayKind::Transmission) != 0 ? "transmitted ray" : "reflected ray";
}

std::string_view lobe_name(shade::Lobe lobe) noexcept
{
    switch (lobe) {
        case shade::Lobe::Diffuse:
            return "diffuse";
        case shade::Lobe::Layer:
            return "specular";
        case shade::Lobe::Coat:
            return "clear coat";
        case shade::Lobe::Transmission:
            return "transmission";
    }
    return {};
}

}  // namespace

void PathLog::starts_in(Vec3f absorption)
{
    if (absorption == Vec3f(0)) out_ << "the camera ray starts in no body that absorbs light\n";
    else out_ << "the camera ray starts in a body that absorbs " << absorption << " a length\n";
}

void PathLog::ray(const accel::Ray& ray)
{
    const double to_world = scale_.to_world();
    out_ << kind_name(ray.kinds) << ": origin " << ray.origin * to_world << ", direction " << ray.direction << ", t from "
         << double(ray.t_near) * to_world << " to " << double(ray.t_far) * to_world << ", footprint "
         << lod::Footprint{scale_.to_world(ray.footprint.a), ray.footprint.b};
    if (ray.start_level != accel::kAnyLevel) out_ << ", start level " << ray.start_level + scale_.exponent();
    if (ray.focus > 0) out_ << " at " << double(ray.focus) * to_world;
    if (ray.time > 0) out_ << ", time " << ray.time;
    out_ << '\n';
}

void PathLog::found(const accel::SurfaceHit& hit)
{
    if (!hit.is_hit()) {
        out_ << "  no hit\n";
        return;
    }
    accel::SurfaceHit world = hit;
    world.t = scale_.to_world(hit.t);
    world.position *= scale_.to_world();
    out_ << "  hit: " << world << '\n';
}

void PathLog::cost(const accel::RayCost& cost) { out_ << "  " << cost << '\n'; }

void PathLog::surface(const Path& path, const accel::SurfaceHit& hit, const shade::Surface& surface)
{
    const Node* node = scene_.find(hit.node);
    out_ << "surface: node " << hit.node;
    if (node && !node->name.empty()) out_ << " '" << printable_line(node->name) << '\'';
    out_ << ", material '" << printable_line(hit.material->name) << "', after " << int(path.bounces)
         << " bounces with throughput " << path.throughput << "\n  normal " << surface.normal << ", base colour "
         << surface.base_color << ", opacity " << surface.opacity << ", diffuse " << surface.diffuse << ", f0 " << surface.f0
         << ", GGX width " << surface.alpha;
    if (surface.coat > 0) out_ << ", coat " << surface.coat << " of width " << surface.coat_alpha;
    if (surface.transmission != Vec3f(0)) out_ << ", transmission " << surface.transmission;
    if (surface.is_solid) out_ << ", refractive index " << surface.eta;
    if (surface.is_straight) out_ << ", a body that does not bend light";
    if (surface.emission != Vec3f(0)) out_ << ", emission " << surface.emission;
    if (surface.unlit) out_ << ", unlit";
    out_ << '\n';
}

void PathLog::added(std::string_view what, Vec3f radiance) { out_ << "  " << what << " adds " << radiance << '\n'; }

void PathLog::light_sample(Vec3f direction, float t_far, Vec3f radiance)
{
    out_ << "  light sample: direction " << direction << ", distance " << double(t_far) * scale_.to_world() << ", adds "
         << radiance << " if nothing is in its way\n";
}

void PathLog::scattered(const shade::ScatterSample& sample, const Path& next)
{
    out_ << "  scattered by the " << lobe_name(sample.lobe) << " lobe: direction " << sample.direction << ", density "
         << sample.density << ", weight " << sample.weight << ", throughput " << next.throughput << '\n';
}

void PathLog::decided(std::string_view what, float chance, bool is_so)
{
    out_ << "  by a chance of " << chance << ", " << what << ": " << (is_so ? "yes" : "no") << '\n';
}

void PathLog::passes(Vec3f transmittance, bool goes_on)
{
    if (goes_on) out_ << "  the ray goes straight on with transmittance " << transmittance << '\n';
    else out_ << "  the ray ends: nothing of its light passes\n";
}

void PathLog::shadow_ray_at(Vec3f direction, float t)
{
    out_ << "the shadow ray in direction " << direction << " meets a surface at t " << double(t) * scale_.to_world() << '\n';
}

}  // namespace occam::render

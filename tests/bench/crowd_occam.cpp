#include "tests/bench/crowd_occam.h"

#include "tests/bench/harness.h"

namespace occam::bench {

OccamCrowd::OccamCrowd(const Crowd& crowd, const Resources& resources) : crowd_(crowd), renderer_(resources)
{
    Material grey;
    grey.base_color = {0.5f, 0.5f, 0.5f, 1};
    grey.roughness = 1;
    grey.specular = 0;
    const MaterialId material = scene_.add(grey);
    for (int i = 0; i < crowd.copies; ++i) {
        Cage cage = crowd.cage;
        cage.materials = {material};
        NodeDesc desc;
        desc.place.translation = crowd.place(i);
        desc.cages = {scene_.add(std::move(cage))};
        cages_.push_back(desc.cages[0]);
        scene_.add_node(scene_.root(), std::move(desc));
    }
    Cage floor;
    floor.scheme = Scheme::Triangles;
    const auto corners = crowd.floor();
    floor.positions.assign(corners.begin(), corners.end());
    floor.face_vertices = {0, 1, 2, 0, 2, 3};
    floor.materials = {material};
    NodeDesc ground;
    ground.cages = {scene_.add(std::move(floor))};
    scene_.add_node(scene_.root(), std::move(ground));
    for (const SquareLight& light : crowd.lights()) {
        AreaLight square;
        square.size = Vec2f(static_cast<float>(light.side));
        square.radiance = Vec3f(20);
        NodeDesc desc;
        desc.light = scene_.add(Light{"", square});
        desc.matrix = Mat4d(Vec4d(light.right, 0), Vec4d(-light.up, 0), Vec4d(-light.towards, 0), Vec4d(light.centre, 1));
        scene_.add_node(scene_.root(), std::move(desc));
    }
    camera_ = Camera::look_at(crowd.eye(), {0, 0, 0}, {0, 1, 0}, 0.78539816f);
}

double OccamCrowd::render(int frame, const Recipe& recipe, int pixels)
{
    const double start = wall_seconds();
    for (int i = 0; i < crowd_.copies; ++i) {
        crowd_.twist(i, frame, positions_);
        scene_.write_vertices(cages_[static_cast<std::size_t>(i)], positions_);
    }
    edit_seconds_ = wall_seconds() - start;
    Settings settings{
        .width = pixels, .height = pixels, .spp = recipe.primary, .integrator = render::IntegratorKind::Direct};
    settings.light_samples = recipe.shadow;
    settings.shading_rate = recipe.edge_pixels;
    renderer_.render(scene_, camera_, settings);
    return wall_seconds() - start;
}

}  // namespace occam::bench

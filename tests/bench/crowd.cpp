#include "tests/bench/crowd.h"

#include <cmath>

namespace occam::bench {

Crowd::Crowd(std::string its_name, Cage at_rest, int count, double c)
    : name(std::move(its_name)), cage(std::move(at_rest)), copies(count), closeness(c)
{
    const Box3d box = cage.bounds();
    const Vec3d size = box.extent();
    const double scale = 1 / std::max({size.x, size.y, size.z});
    for (Vec3f& p : cage.positions) p = Vec3f((Vec3d(p) - box.centre()) * scale);
}

int Crowd::side() const noexcept
{
    int n = 1;
    while (n * n < copies) ++n;
    return n;
}

Vec3d Crowd::place(int copy) const noexcept
{
    const int n = side();
    return {1.2 * (copy % n - (n - 1) * 0.5), 0, 1.2 * (copy / n - (n - 1) * 0.5)};
}

Vec3d Crowd::eye() const noexcept { return Vec3d(0.1, 0.45, -0.85) * (closeness * extent()); }

std::array<SquareLight, 2> Crowd::lights() const noexcept
{
    std::array<SquareLight, 2> lights;
    const Vec3d places[2] = {{-0.7, 0.9, -0.3}, {0.8, 0.7, -0.5}};
    for (int l = 0; l < 2; ++l) {
        SquareLight& light = lights[static_cast<std::size_t>(l)];
        light.centre = places[l] * extent();
        light.towards = -glm::normalize(light.centre);
        light.right = glm::normalize(glm::cross(Vec3d(0, 1, 0), light.towards));
        light.up = glm::cross(light.towards, light.right);
        light.side = 0.15 * extent();
    }
    return lights;
}

std::array<Vec3f, 4> Crowd::floor() const noexcept
{
    const auto half = static_cast<float>(extent());
    return {{{-half, -0.6f, half}, {half, -0.6f, half}, {half, -0.6f, -half}, {-half, -0.6f, -half}}};
}

void Crowd::twist(int copy, int frame, std::vector<Vec3f>& positions) const
{
    const double a = 0.3 * std::sin(0.7 * frame + copy);
    positions.resize(cage.positions.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Vec3f p = cage.positions[v];
        const auto angle = static_cast<float>(2 * a * double(p.y));
        const float s = std::sin(angle), c = std::cos(angle);
        positions[v] = {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
    }
}

}  // namespace occam::bench

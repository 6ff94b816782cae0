#include "tests/support/creased_cages.h"

#include "base/hash.h"

namespace occam::test {
namespace {

// Sharpens edges and vertices by the numbers that `sharpness` returns.
template <class Sharpness, class Number>
void sharpen(Cage& cage, std::uint64_t one_in, Sharpness&& sharpness, Number&& number)
{
    cage.creases.clear();
    cage.corners.clear();
    for (Crease edge : edges_of(cage)) {
        edge.sharpness = sharpness();
        if (number(one_in) == 0) cage.creases.push_back(edge);
    }
    for (std::uint32_t v = 0; v < cage.positions.size(); ++v)
        if (number(12) == 0) cage.corners.push_back({v, sharpness()});
}

// Returns a function that draws a number below its argument.
auto numbers(std::uint64_t seed)
{
    return [state = seed](std::uint64_t count) mutable { return mix_bits(state += 0x9e3779b97f4a7c15ull) % count; };
}

}  // namespace

std::vector<Crease> edges_of(const Cage& cage)
{
    std::vector<Crease> edges;
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 0; i < size; ++i) {
            const std::uint32_t a = cage.face_vertices[first + i], b = cage.face_vertices[first + (i + 1) % size];
            if (a < b) edges.push_back({a, b, 0});
        }
        first += size;
    }
    return edges;
}

Cage creased(Cage cage, std::uint64_t seed)
{
    auto number = numbers(seed);
    const std::uint64_t one_in = 1 + number(6);
    sharpen(
        cage, one_in, [&] { return 0.25f * static_cast<float>(1 + number(45)); }, number);
    return cage;
}

Cage creased_evenly(Cage cage, float sharpness, std::uint64_t one_in, std::uint64_t seed)
{
    sharpen(
        cage, one_in, [sharpness] { return sharpness; }, numbers(seed));
    return cage;
}

}  // namespace occam::test

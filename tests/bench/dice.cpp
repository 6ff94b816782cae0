// The suite measures the cost of a point with both tangents: for one patch's grid through PosedPatch and through Dicer, and
// for the same points through Bfr.
//
// PosedPatch  For "evaluate", control points are already posed and pieces are made. "pose_and_evaluate" includes this
//             work, as a patch's first tile does.
// Dicer       The suite calls dice() and shade() for a tile of a patch that is not posed yet. This includes borders from
//             their owners, gap triangles and unit normals.
// Bfr         Evaluate is called once for each point; its patch points are prepared beforehand.

#include <cmath>

#include "lod/dicer.h"
#include "tests/bench/bfr_patch.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRuns = 7;
constexpr lod::PatchRef kPatch{0, 0};

struct Worst {
    double position = 0;    ///< largest difference, as a share of the cage's extent
    double normal_deg = 0;  ///< largest difference where there is a normal

    void add(const LimitPoint& ours, const LimitPoint& theirs, double extent)
    {
        position = std::max(position, glm::distance(ours.p, theirs.p) / extent);
        const Vec3d a = glm::cross(ours.du, ours.dv), b = glm::cross(theirs.du, theirs.dv);
        const double sine = glm::length(glm::cross(a, b)), cosine = glm::dot(a, b);
        if (glm::length(a) > 0 && glm::length(b) > 0)
            normal_deg = std::max(normal_deg, std::atan2(sine, cosine) * 180 / 3.14159265358979323846);
    }
};

/// Holds runs of a grid of 2^exponent quads along a side.
struct Grid {
    int exponent, side = (1 << exponent) + 1;
    std::size_t count = static_cast<std::size_t>(side * side);
    int repeats = 200'000 / static_cast<int>(count);
    double to_ns = 1e9 / (double(count) * repeats);
};

// Returns the times of dicing and shading a tile of a patch that is not posed yet.
std::vector<double> dice_times(const Subject& subject, const Grid& grid)
{
    // There are as many cages as patches to dice, since a dicer keeps those that it has posed.
    const std::vector<lod::PosedCage> copies(static_cast<std::size_t>(grid.repeats), subject.posed);
    lod::Dicer dicer;
    Arena arena;
    const auto size = static_cast<std::uint16_t>(grid.side - 1);
    const int e = grid.exponent;
    const lod::TileRef tile{kPatch, {e, e, {e, e, e, e}}, 0, 0, size, size};
    const auto run = [&] {
        arena.reset();
        dicer.forget();
        for (const lod::PosedCage& cage : copies) dicer.dice(cage, tile, arena), dicer.shade(cage, tile, tile.rates, arena);
    };
    return times(repeat(kRuns, run), grid.to_ns);
}

void run_grid(Report& report, const std::string& name, const Subject& subject, const BfrPatch& bfr, int exponent)
{
    const Grid of{exponent};
    const int side = of.side;
    const std::size_t count = of.count;
    const float step = std::ldexp(1.0f, -exponent);

    lod::PosedPatch patch;
    std::vector<float> rows(9 * count);
    float* out[9];
    for (std::size_t k = 0; k < 9; ++k) out[k] = rows.data() + k * count;
    const auto evaluate = [&] { patch.points_and_tangents({0, 0, step, step, side, side}, out, side); };
    const auto many = [&](auto&& work) {
        return times(repeat(kRuns,
                            [&] {
                                for (int i = 0; i < of.repeats; ++i) work();
                            }),
                     of.to_ns);
    };
    patch.set(subject.posed, kPatch);
    evaluate();  // classes grow on demand, once for each topology
    const std::vector<double> evaluated = many(evaluate);
    const std::vector<double> posed = many([&] { patch.set(subject.posed, kPatch), evaluate(); });

    const std::vector<double> diced = dice_times(subject, of);

    std::vector<float> uv;
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i) uv.insert(uv.end(), {float(i) * step, float(j) * step});
    const std::vector<double> uv_double(uv.begin(), uv.end());
    std::vector<std::array<float, 9>> in_float(count);
    std::vector<LimitPoint> in_double(count);
    const std::vector<double> bfr_float = many([&] { bfr.evaluate_float(uv, in_float); });
    const std::vector<double> bfr_double = many([&] { bfr.evaluate_double(uv_double, in_double); });

    const double extent = glm::length(subject.posed.slot->bounds.extent());
    Worst ours, theirs;
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = [&](std::size_t k) { return Vec3d(out[k][i], out[k + 1][i], out[k + 2][i]); };
        const auto theirs_at = [&](std::size_t k) { return Vec3d(in_float[i][k], in_float[i][k + 1], in_float[i][k + 2]); };
        ours.add({at(0), at(3), at(6)}, in_double[i], extent);
        theirs.add({theirs_at(0), theirs_at(3), theirs_at(6)}, in_double[i], extent);
    }
    const std::string grid = std::to_string(side) + " x " + std::to_string(side);
    Row row{"dice", name + ", " + grid};
    row.add("evaluate_ns_per_point", evaluated)
        .add("pose_and_evaluate_ns_per_point", posed)
        .add("dicer_ns_per_point", diced);
    row.add("bfr_float_ns_per_point", bfr_float).add("bfr_double_ns_per_point", bfr_double);
    row.add("position_error_of_extent", ours.position).add("normal_error_deg", ours.normal_deg);
    report.add(row.add("bfr_float_position_error", theirs.position).add("bfr_float_normal_error_deg", theirs.normal_deg));
}

}  // namespace

void run_dice(Report& report)
{
    const struct {
        const char* name;
        Cage cage;
    } kinds[] = {{"regular", fan(4)},
                 {"valence 3", fan(3)},
                 {"valence 5", fan(5)},
                 {"valence 8", fan(8)},
                 {"crease of 2.5", fan(4, 2.5f)}};
    for (const auto& [name, cage] : kinds) {
        const Subject subject(name, cage, 640, 360);
        std::vector<Vec3f> positions;
        for (const Vec3f p : cage.positions) positions.push_back(subject.posed.pose(p));
        const BfrPatch bfr(cage, positions, 0);
        for (const int exponent : {2, 3, 4}) run_grid(report, name, subject, bfr, exponent);
    }
}

}  // namespace occam::bench

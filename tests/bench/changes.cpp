// The suite measures what a frame's unseen objects cost, and what an edit costs in a large scene.
#include <cmath>

#include "api/include/occam/occam.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"

namespace occam::bench {
namespace {

constexpr int kRounds = 5;

NodeId add_node(Scene& scene, NodeId parent, Vec3d at, CageId cage = {})
{
    NodeDesc desc;
    desc.place.translation = at;
    if (cage) desc.cages = {cage};
    return scene.add_node(parent, std::move(desc));
}

// Holds a torus in front of a wall. As many tori of 5,000 faces as asked for stand behind the wall and beside the picture,
// half of them each. A morph target makes all of them swell, anew in every frame.
class HiddenCrowd {
public:
    explicit HiddenCrowd(int copies) : renderer_({.threads = 1})
    {
        Cage ring = torus(100, 50);
        MorphTarget swollen;
        for (const Vec3f p : ring.positions) swollen.positions.push_back(Vec3f(0, p.y * 0.3f, 0));
        ring.morph_targets = {swollen};
        ring.morph_weights = {0};
        const CageId shape = scene_.add(std::move(ring));
        seen_ = add_node(scene_, scene_.root(), Vec3d(0), shape);
        Cage wall;
        wall.scheme = Scheme::Triangles;
        wall.positions = {{-90, -90, -3}, {90, -90, -3}, {0, 180, -3}};
        wall.face_vertices = {0, 1, 2};
        add_node(scene_, scene_.root(), Vec3d(0), scene_.add(std::move(wall)));
        const NodeId groups[2] = {add_node(scene_, scene_.root(), {0, 0, -10}),
                                  add_node(scene_, scene_.root(), {500, 0, 0})};
        for (int i = 0; i < copies; ++i)
            hidden_.push_back(
                add_node(scene_, groups[i % 2], {3.0 * (i / 2 % 10 - 5), 3.0 * (i / 20 % 10 - 5), -3.0 * (i / 200)}, shape));
    }
    void render(int frame)
    {
        const std::vector<float> weight{float(std::sin(0.7 * frame))};
        scene_.set_morph_weights(seen_, weight);
        for (const NodeId node : hidden_) scene_.set_morph_weights(node, weight);
        renderer_.render(scene_, Camera::look_at({0, 2.5, 4}, {0, 0, 0}, {0, 1, 0}, 0.7f),
                         {.width = 320, .height = 240, .spp = 4});
    }
    const FrameStats& stats() const { return renderer_.stats(); }

private:
    Scene scene_;
    Renderer renderer_;
    NodeId seen_;
    std::vector<NodeId> hidden_;
};

}  // namespace

void run_hidden(Report& report)
{
    std::vector<std::unique_ptr<HiddenCrowd>> crowds;
    constexpr int kCopies[] = {0, 20, 200, 2000};
    for (const int copies : kCopies) crowds.push_back(std::make_unique<HiddenCrowd>(copies));
    std::vector<std::vector<double>> seconds(crowds.size());
    for (int frame = 0; frame <= kRounds; ++frame)
        for (std::size_t c = 0; c < crowds.size(); ++c) {
            const double start = process_seconds();
            crowds[c]->render(frame);
            if (frame > 0) seconds[c].push_back(process_seconds() - start);
        }
    for (std::size_t c = 0; c < crowds.size(); ++c) {
        const FrameStats& s = crowds[c]->stats();
        Row row{"hidden", std::to_string(kCopies[c] * 5000) + " hidden faces"};
        row.add("frame_cpu_seconds", seconds[c]).add("over_none_hidden", ratios(seconds[c], seconds[0]));
        row.add("over_first", ratios(seconds[c], seconds[1])).add("rebuilt_bytes", double(s.memory.arena_peak_bytes));
        row.add("faces_touched", double(s.built.faces_touched)).add("vertices_deformed", double(s.built.vertices_deformed));
        report.add(std::move(row));
    }
}

namespace {

constexpr std::size_t kEdits = 10;

// Measures kEdits edits in each frame; `edit(frame, e)` makes the e-th of them.
template <class Edit>
void measure_edits(Report& report, Scene& scene, const std::string& name, int depth, Edit&& edit)
{
    if (!report.wants(name)) return;
    scene.refit();
    std::size_t looked_at = 0;
    int frame = 0;
    const std::vector<double> seconds = repeat(50, [&] {
        ++frame;
        for (std::size_t e = 0; e < kEdits; ++e) edit(std::size_t(frame), e);
        looked_at = scene.refit();
    });
    Row out{"edits", name};
    out.add("microseconds_an_edit", times(seconds, 1e6 / double(kEdits)));
    out.add("microseconds_an_edit_and_depth", times(seconds, 1e6 / double(kEdits) / depth));
    out.add("nodes_and_boxes_looked_at", double(looked_at)).add("edits", double(kEdits));
    report.add(std::move(out));
}

Mat4d moved(std::size_t x, std::size_t y)
{
    Mat4d place(1);
    place[3] = Vec4d(double(x), double(y), 0, 1);
    return place;
}

void run_deep_edits(Report& report)
{
    constexpr std::size_t kFanOut = 10;
    Scene scene;
    const CageId shape = scene.add(torus(8, 6));
    std::vector<NodeId> row{scene.root()};
    std::size_t nodes = 1;
    for (int depth = 1; depth <= 6; ++depth) {
        std::vector<NodeId> below;
        for (const NodeId parent : row)
            for (std::size_t c = 0; c < kFanOut; ++c)
                below.push_back(add_node(scene, parent, {double(c), 0, 0}, depth == 6 ? shape : CageId{}));
        row = std::move(below);
        nodes += row.size();
        if (depth < 2) continue;
        measure_edits(report, scene, std::to_string(nodes) + " nodes, " + std::to_string(depth) + " deep", depth,
                      [&](std::size_t frame, std::size_t e) {
                          scene.set_transform(row[(e * row.size() / kEdits + frame * 7919) % row.size()], moved(frame, e));
                      });
    }
}

// Measures edits where one node has all others below it.
void run_flat_edits(Report& report)
{
    Scene scene;
    const CageId shape = scene.add(torus(8, 6));
    std::vector<NodeId> nodes;
    for (std::size_t count = 100; count <= 1'000'000; count *= 10) {
        while (nodes.size() < count) nodes.push_back(add_node(scene, scene.root(), {double(nodes.size()), 0, 0}, shape));
        const auto at = [&](std::size_t frame, std::size_t e) -> NodeId& {
            return nodes[(e * count / kEdits + frame * 7919) % count];
        };
        const std::string name = std::to_string(count) + " nodes, side by side";
        measure_edits(report, scene, name, 1,
                      [&](std::size_t frame, std::size_t e) { scene.set_transform(at(frame, e), moved(frame, e)); });
        measure_edits(report, scene, name + ", one removed and one added", 1, [&](std::size_t frame, std::size_t e) {
            scene.remove(at(frame, e));
            at(frame, e) = add_node(scene, scene.root(), {double(e), 0, 0}, shape);
        });
    }
}

}  // namespace

void run_edits(Report& report)
{
    run_deep_edits(report);
    run_flat_edits(report);
}

}  // namespace occam::bench

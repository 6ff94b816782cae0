#include "scenegraph/deformed_poles.h"

#include <map>
#include <utility>

namespace occam {

/// Collects what the faces at the poles of a skinned cage are moved by.
class DeformedPoles::Builder {
public:
    explicit Builder(const Cage& cage) : cage_(cage) {}

    void add(std::span<const std::uint32_t> face, const Poles& lengths, std::uint32_t classes)
    {
        of_face_.clear();
        for (std::size_t c = 0; c < face.size(); ++c) add_corner(face[c]);
        Box3f box;
        for (const std::uint32_t v : face) box.add(cage_.positions[v]);
        const auto main = std::max_element(of_face_.begin(), of_face_.end(),
                                           [](const auto& a, const auto& b) { return a.second.sum < b.second.sum; });
        std::size_t others = 0;
        for (auto& [joint, weights] : of_face_) {
            joints_[joint].add(lengths);
            if (weights.corners < face.size()) weights.least = 0;
            others += joint != main->first && weights.range() > 0;
        }
        for (const auto& [joint, weights] : of_face_) {
            if (joint == main->first || !(weights.range() > 0)) continue;
            auto& [share, around] = beside_[{main->first, joint}];
            share.add(classes, double(others) * weights.range());
            around.add(box);
        }
    }
    void move_to(DeformedPoles& to)
    {
        for (const auto& [joint, longest] : joints_) to.joints_.push_back({joint, longest});
        for (const auto& [pair, of] : beside_) to.beside_.push_back({pair.first, pair.second, of.first, of.second});
    }

private:
    struct Weights {
        double least = 1, most = 0, sum = 0;
        std::size_t corners = 0;
        double range() const noexcept { return most - least; }
    };

    void add_corner(std::uint32_t vertex)
    {
        const auto for_each_weight = [&](const auto& visit) {
            for (int set = 0; set < cage_.skin.sets; ++set) {
                const std::size_t at = std::size_t(set) * cage_.positions.size() + vertex;
                for (int k = 0; k < 4; ++k)
                    if (cage_.skin.weights[at][k] > 0) visit(cage_.skin.joints[at][k], double(cage_.skin.weights[at][k]));
            }
        };
        // A joint may be named twice. Weights are those of a mean.
        double total = 0;
        of_corner_.clear();
        for_each_weight([&](std::uint16_t joint, double weight) {
            of_corner_[joint] += weight;
            total += weight;
        });
        for (const auto& [joint, weight] : of_corner_) {
            Weights& of = of_face_[joint];
            of.least = std::min(of.least, weight / total);
            of.most = std::max(of.most, weight / total);
            of.sum += weight / total;
            ++of.corners;
        }
    }

    const Cage& cage_;
    std::map<std::uint16_t, double> of_corner_;
    std::map<std::uint16_t, Weights> of_face_;
    std::map<std::uint16_t, Poles> joints_;
    std::map<std::pair<std::uint16_t, std::uint16_t>, std::pair<Poles, Box3f>> beside_;
};

DeformedPoles::DeformedPoles(const Cage& cage, const PoleFaces& faces)
{
    if (faces.is_empty()) return;
    for (const MorphTarget& target : cage.morph_targets)
        targets_.push_back(target.positions.empty() ? Poles() : faces.measure(cage, target.positions));
    if (cage.skin.sets == 0) return;
    Builder builder(cage);
    faces.for_each(cage, cage.positions,
                   [&](std::span<const std::uint32_t> face, const Poles& lengths, std::uint32_t classes) {
                       builder.add(face, lengths, classes);
                   });
    builder.move_to(*this);
}

Poles DeformedPoles::morphed(Poles rest, std::span<const float> weights) const noexcept
{
    for (std::size_t t = 0; t < std::min(targets_.size(), weights.size()); ++t)
        rest.lengthen(targets_[t].scaled(std::abs(double(weights[t]))));
    return rest;
}

}  // namespace occam

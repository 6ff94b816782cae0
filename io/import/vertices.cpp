#include "io/import/vertices.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "io/import/bits_key.h"
#include "io/import/key_numbers.h"
#include "io/import/polygons.h"

namespace occam::import {

namespace {

// Returns what four joints of a vertex are to it, in an order of their own: a joint without weight does not matter.
BitsKey<8> key_of(const SkinBinding& skin, std::size_t at)
{
    std::array<std::pair<std::uint32_t, std::uint32_t>, 4> joints;
    for (int k = 0; k < 4; ++k) {
        const float weight = skin.weights[at][k];
        joints[std::size_t(k)] = {weight != 0 ? skin.joints[at][k] : 0, bits_of(weight)};
    }
    std::sort(joints.begin(), joints.end());
    BitsKey<8> key;
    for (std::size_t k = 0; k < 4; ++k) key[2 * k] = joints[k].first, key[2 * k + 1] = joints[k].second;
    return key;
}

// Gives vertices of one place but of different keys, which have N words, places of their own.
template <std::size_t N, class KeyOf>
void part(VertexPlaces& places, KeyOf&& key_of_vertex)
{
    KeyNumbers<N + 1> known;
    for (std::size_t v = 0; v < places.of.size(); ++v) {
        const BitsKey<N> own = key_of_vertex(v);
        BitsKey<N + 1> key{places.of[v]};
        std::copy(own.begin(), own.end(), key.begin() + 1);
        places.of[v] = known.number_of(key);
    }
    places.count = known.size();
}

// Moves vertices to their places; of several vertices that go to one place the first stays.
struct Renumbering {
    const std::vector<std::uint32_t> new_of;
    const std::size_t count;

    template <class T>
    void apply(std::vector<T>& values) const
    {
        if (values.empty()) return;
        std::vector<T> out(count);
        for (std::size_t v = new_of.size(); v-- > 0;) out[new_of[v]] = values[v];
        values = std::move(out);
    }
    template <class T>
    void apply_sets(std::vector<T>& values, int sets) const
    {
        std::vector<T> out;
        for (std::size_t s = 0; s < static_cast<std::size_t>(sets); ++s) {
            const auto first = values.begin() + static_cast<std::ptrdiff_t>(s * new_of.size());
            std::vector<T> one(first, first + static_cast<std::ptrdiff_t>(new_of.size()));
            apply(one);
            out.insert(out.end(), one.begin(), one.end());
        }
        values = std::move(out);
    }
    // This moves everything that has one entry for each vertex, except texture coordinates.
    void apply(Cage& cage) const
    {
        apply(cage.positions);
        apply(cage.normals);
        if (cage.color_indices.empty()) apply(cage.colors);
        for (MorphTarget& target : cage.morph_targets) apply(target.positions);
        apply_sets(cage.skin.joints, cage.skin.sets);
        apply_sets(cage.skin.weights, cage.skin.sets);
        for (std::uint32_t& v : cage.face_vertices) v = v < new_of.size() ? new_of[v] : kNoIndex;
    }
};

// Turns one value for each vertex into one for each corner: vertices that are joined may have several, each kept once.
template <class Vec>
void weld_values(std::vector<Vec>& values, std::vector<std::uint32_t>& indices, const Cage& cage,
                 const Renumbering& renumbering)
{
    constexpr std::size_t kFloats = Vec::length();
    KeyNumbers<kFloats + 1> known;
    std::vector<Vec> kept;
    for (const std::uint32_t v : cage.face_vertices) {
        if (v >= values.size()) {
            indices.push_back(0);
            continue;
        }
        BitsKey<kFloats + 1> key{renumbering.new_of[v]};
        for (std::size_t i = 0; i < kFloats; ++i) key[i + 1] = bits_of(values[v][static_cast<int>(i)]);
        indices.push_back(known.number_of(key));
        if (indices.back() == kept.size()) kept.push_back(values[v]);
    }
    values = std::move(kept);
}

}  // namespace

std::optional<std::vector<std::uint32_t>> choose_used_vertices(std::vector<std::uint32_t>& corners, std::size_t vertices)
{
    constexpr std::size_t kFew = 8;  // so many vertices for a corner still take less time in a table than in a sorted list
    std::vector<std::uint32_t> used;
    if (vertices / kFew <= corners.size()) {
        std::vector<std::uint32_t> new_of(vertices, kNoIndex);
        for (const std::uint32_t v : corners)
            if (v < vertices) new_of[v] = 0;
        for (std::size_t v = 0; v < vertices; ++v) {
            if (new_of[v] == kNoIndex) continue;
            new_of[v] = static_cast<std::uint32_t>(used.size());
            used.push_back(static_cast<std::uint32_t>(v));
        }
        if (used.size() == vertices) return std::nullopt;
        for (std::uint32_t& v : corners) v = v < vertices ? new_of[v] : kNoIndex;
        return used;
    }
    std::copy_if(corners.begin(), corners.end(), std::back_inserter(used), [&](std::uint32_t v) { return v < vertices; });
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto new_of = [&](std::uint32_t v) {
        return static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
    };
    for (std::uint32_t& v : corners) v = v < vertices ? new_of(v) : kNoIndex;
    return used;
}

VertexPlaces places_of(const Cage& cage)
{
    VertexPlaces places;
    KeyNumbers<3> at_rest;
    const std::size_t vertices = cage.positions.size();
    places.of.reserve(vertices);
    for (const Vec3f p : cage.positions) places.of.push_back(at_rest.number_of({bits_of(p.x), bits_of(p.y), bits_of(p.z)}));
    places.count = at_rest.size();
    for (const MorphTarget& target : cage.morph_targets)
        if (target.positions.size() == vertices)
            part<3>(places, [&](std::size_t v) {
                const Vec3f move = target.positions[v];
                return BitsKey<3>{bits_of(move.x), bits_of(move.y), bits_of(move.z)};
            });
    for (int set = 0; set < cage.skin.sets; ++set)
        part<8>(places, [&](std::size_t v) { return key_of(cage.skin, static_cast<std::size_t>(set) * vertices + v); });
    return places;
}

void weld(Cage& cage)
{
    VertexPlaces places = places_of(cage);
    const Renumbering renumbering{std::move(places.of), places.count};
    cage.normals.clear();
    for (MorphTarget& target : cage.morph_targets) target.normals.clear();
    for (UvSet& set : cage.uv_sets)
        if (set.indices.empty()) weld_values(set.values, set.indices, cage, renumbering);
    if (!cage.colors.empty() && cage.color_indices.empty()) weld_values(cage.colors, cage.color_indices, cage, renumbering);
    renumbering.apply(cage);
}

}  // namespace occam::import

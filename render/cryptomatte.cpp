#include "render/cryptomatte.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <map>
#include <unordered_set>

#include "base/json_document.h"
#include "scenegraph/shown_nodes.h"

namespace occam::render {
namespace {

std::uint32_t id_bits(std::string_view name) noexcept { return std::bit_cast<std::uint32_t>(matte_id(name)); }

std::string hex(std::uint32_t value)
{
    char text[9];
    std::snprintf(text, sizeof text, "%08x", value);
    return text;
}

// Returns a name as UTF-8, as JSON has to be. A name that is something else is taken for Latin-1, in which old OBJ and MTL
// files are written, so that names that differ stay apart.
std::string utf8_of(std::string_view name)
{
    std::string text(name);
    try {
        (void)nlohmann::json(text).dump();
    } catch (const nlohmann::json::type_error&) {
        text.clear();
        for (const char c : name) {
            const auto byte = static_cast<unsigned char>(c);
            if (byte < 0x80) text += c;
            else text.append({static_cast<char>(0xc0 | byte >> 6), static_cast<char>(0x80 | (byte & 0x3f))});
        }
    }
    return text;
}

std::string manifest_of(Aov aov, const Scene& scene)
{
    JsonDocument document;
    nlohmann::json& manifest = document.root = nlohmann::json::object();
    const auto add = [&](std::string_view name) { manifest[utf8_of(name)] = hex(id_bits(name)); };
    const auto add_materials = [&](const std::vector<MaterialId>& ids) {
        for (const MaterialId id : ids)
            if (const Material* material = scene.find(id)) add(matte_name(*material));
    };
    if (aov == Aov::CryptomatteMaterial) add(matte_name(Material()));
    std::unordered_set<CageId> cages;  // those whose materials were added
    for_each_shown_node(scene, 0, [&](NodeId id, const Node& node) {
        if (node.cages.empty()) return;
        if (aov == Aov::CryptomatteObject) {
            add(matte_name(scene, id));
            return;
        }
        add_materials(node.materials);
        for (const CageId cage : node.cages)
            if (const CageSlot* slot = scene.find(cage); slot && cages.insert(cage).second)
                add_materials(slot->cage.materials);
    });
    return manifest.dump();
}

}  // namespace

std::uint32_t murmur3(std::string_view text) noexcept
{
    const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
    const auto scramble = [](std::uint32_t k) { return std::rotl(k * 0xcc9e2d51u, 15) * 0x1b873593u; };
    std::uint32_t h = 0;
    std::size_t i = 0;
    for (; i + 4 <= text.size(); i += 4) {
        h ^= scramble(byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24);
        h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    }
    std::uint32_t rest = 0;
    for (std::size_t k = text.size(); k > i; --k) rest = rest << 8 | byte(k - 1);
    h ^= scramble(rest);
    h ^= static_cast<std::uint32_t>(text.size());
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    return h ^ h >> 16;
}

float matte_id(std::string_view name) noexcept
{
    std::uint32_t bits = murmur3(name);
    const std::uint32_t exponent = bits >> 23 & 255;
    if (exponent == 0 || exponent == 255) bits ^= 1u << 23;
    return std::bit_cast<float>(bits);
}

std::string_view matte_name(const Scene& scene, NodeId node) noexcept
{
    const Node* found = scene.find(node);
    return found && !found->name.empty() ? std::string_view(found->name) : std::string_view("unnamed");
}

std::string_view matte_name(const Material& material) noexcept
{
    return material.name.empty() ? std::string_view("unnamed") : std::string_view(material.name);
}

void MatteSums::add(float id, double coverage)
{
    const auto known = std::find_if(shares_.begin(), shares_.end(), [&](const Share& s) { return s.id == id; });
    const auto mass = static_cast<float>(std::abs(coverage));
    if (known != shares_.end()) {
        known->mass += mass;
        known->coverage += coverage;
        return;
    }
    if (restore({id, mass, coverage})) return;
    const auto least = std::ranges::min_element(shares_, {}, &Share::mass);
    *least = {id, least->mass + mass, coverage};
}

bool MatteSums::restore(const Share& share)
{
    if (shares_.size() == kMostIds) return false;
    shares_.push_back(share);
    return true;
}

void MatteSums::rank(double weight, float (&out)[2 * kMatteRanks])
{
    std::fill(std::begin(out), std::end(out), 0.0f);
    if (!(weight > 0)) return;
    std::sort(shares_.begin(), shares_.end(), [](const Share& a, const Share& b) {
        if (a.coverage != b.coverage) return a.coverage > b.coverage;
        return std::bit_cast<std::uint32_t>(a.id) < std::bit_cast<std::uint32_t>(b.id);
    });
    const std::size_t count = std::min<std::size_t>(shares_.size(), kMatteRanks);
    for (std::size_t i = 0; i < count && shares_[i].coverage > 0; ++i) {
        out[2 * i] = shares_[i].id;
        out[2 * i + 1] = static_cast<float>(shares_[i].coverage / weight);
    }
}

std::string_view matte_layer(Aov aov) noexcept
{
    if (aov == Aov::CryptomatteObject) return "CryptoObject";
    if (aov == Aov::CryptomatteMaterial) return "CryptoMaterial";
    return "";
}

void describe_mattes(Image& image, const Scene& scene, const Settings& settings)
{
    for (const Aov aov : {Aov::CryptomatteObject, Aov::CryptomatteMaterial}) {
        if (!settings.has(aov)) continue;
        const std::string name(matte_layer(aov));
        const std::string head = "cryptomatte/" + hex(murmur3(name)).substr(0, 7) + "/";
        image.attributes.push_back({head + "name", name});
        image.attributes.push_back({head + "hash", std::string("MurmurHash3_32")});
        image.attributes.push_back({head + "conversion", std::string("uint32_to_float32")});
        image.attributes.push_back({head + "manifest", manifest_of(aov, scene)});
    }
}

}  // namespace occam::render

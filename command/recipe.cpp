#include "recipe.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <set>
#include <type_traits>

#include "base/hash.h"
#include "io/input_file.h"

namespace occam::command {
namespace {

namespace fs = std::filesystem;

constexpr char kBeforeVersion[] = "Occam ", kBeforeNumber[] = ", recipe ";  // the parts of a note
constexpr char kUnfinished[] = ", unfinished";                              // follows the note of a picture that was stopped

class Fingerprint {
public:
    void add(const std::string& text)
    {
        add(text.size());
        hash_ = fnv1a(text.data(), text.size(), hash_);
    }
    template <class T>
    requires std::is_arithmetic_v<T>
    void add(T value)
    {
        const auto number = static_cast<double>(value);
        hash_ = fnv1a(&number, sizeof number, hash_);
    }
    template <class... Ts>
    void add(const Ts&... values) requires(sizeof...(Ts) > 1)
    {
        (add(values), ...);
    }
    /// Adds the bytes of a regular file; any other, such as a pipe, might have no end.
    void add_bytes_of(const fs::path& file)
    {
        std::error_code error;
        if (!fs::is_regular_file(file, error)) return add(-1);
        std::ifstream in(file, std::ios::binary);
        std::string block(std::size_t(1) << 16, '\0');
        std::uint64_t size = 0;
        while (in.read(block.data(), static_cast<std::streamsize>(block.size())) || in.gcount() > 0) {
            hash_ = hash_in_eights(block.data(), static_cast<std::size_t>(in.gcount()), hash_);
            size += static_cast<std::uint64_t>(in.gcount());
        }
        add(size);
    }
    /// Adds the size of a file, and its bytes; of a large one those at both ends.
    void add_ends_of(const fs::path& file)
    {
        constexpr std::uintmax_t kEnd = std::uintmax_t(1) << 16;
        std::error_code error;
        const std::uintmax_t size = fs::file_size(file, error);
        if (error) return add(-1);
        add(size);
        std::ifstream in(file, std::ios::binary);
        std::string block(static_cast<std::size_t>(std::min(size, kEnd)), '\0');
        for (const std::uintmax_t from : {std::uintmax_t(0), std::max(size, kEnd) - kEnd}) {
            in.seekg(static_cast<std::streamoff>(from));
            in.read(block.data(), static_cast<std::streamsize>(block.size()));
            hash_ = fnv1a(block.data(), static_cast<std::size_t>(in.gcount()), hash_);
        }
    }
    std::uint64_t value() const { return mix_bits(hash_); }

private:
    std::uint64_t hash_ = kFnvStart;
};

}  // namespace

std::uint64_t scene_stamp(Scene& scene, const RenderArguments& a, Renderer& renderer)
{
    Fingerprint print;
    if (!a.scene.empty()) print.add_bytes_of(a.scene);
    if (!a.environment.empty()) print.add_bytes_of(a.environment);
    // Images may be far larger than what is read of them.
    std::set<fs::path> images;
    for (const TextureId id : scene.texture_ids()) images.insert(scene.texture(id).path);
    for (const fs::path& file : scene.files)
        if (images.contains(file)) print.add_ends_of(file);
        else if (file != a.scene && file != a.environment) print.add_bytes_of(file);
    const Scene::Counts counts = scene.counts();
    print.add(counts.nodes, counts.cages, counts.faces, counts.materials, counts.textures, counts.lights, counts.skins);
    const Box3d bounds = scene.bounds();
    print.add(bounds.lo.x, bounds.lo.y, bounds.lo.z, bounds.hi.x, bounds.hi.y, bounds.hi.z);
    print.add(static_cast<int>(a.load.subdivide), a.load.variant, a.has_environment, a.environment_strength,
              a.environment_rotation_deg);
    return print.value() ^ renderer.halvings(scene);
}

std::string recipe_note(std::uint64_t scene_stamp, const Recipe& recipe)
{
    const auto& [a, write, settings, camera, moment] = recipe;
    // The deadline decides when a picture stops, not what it shows; what is strict decides whether there is a picture.
    Settings lasting = settings;
    lasting.strict = false;
    lasting.deadline_s = 0;
    lasting.progressive = false;
    Fingerprint print;
    print.add(std::to_string(scene_stamp), std::string(render::kVersion), render::to_json(lasting), a.clip, a.fps,
              a.shutter_segments, moment.has_value(), moment.value_or(0));
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) print.add(camera.world_from_camera[c][r]);
    const CameraLens& lens = camera.lens;
    print.add(lens.fov, lens.aspect, lens.orthographic, lens.height, lens.radius, lens.focus, lens.blades);
    if (Image::is_for_display(a.output))
        print.add(write.exposure_ev.has_value(), write.exposure_ev.value_or(0), static_cast<int>(write.tonemap));
    else print.add(write.half);
    char text[64];
    std::snprintf(text, sizeof text, "%s%s%s%016llx", kBeforeVersion, std::string(render::kVersion).c_str(), kBeforeNumber,
                  static_cast<unsigned long long>(print.value()));
    return text;
}

bool is_recipe_note(std::string_view text)
{
    constexpr std::size_t kDigits = 16;
    const std::size_t at = text.rfind(kBeforeNumber);
    if (!text.starts_with(kBeforeVersion) || at == std::string_view::npos) return false;
    const std::string_view number = text.substr(at + std::string_view(kBeforeNumber).size());
    return number.size() == kDigits && number.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string note_in_file(const std::string& note, bool is_complete) { return is_complete ? note : note + kUnfinished; }

FoundPicture look_for(const fs::path& file, const Settings& settings, const std::string& note)
{
    using State = FoundPicture::State;
    std::error_code error;
    if (!fs::exists(file, error)) return {};
    if (std::string why = why_unreadable(file); !why.empty()) return {State::Unreadable, std::move(why)};
    render::PictureHead head;
    try {
        head = Image::read_head(file);
    } catch (const Error& broken) {
        return {State::Broken, broken.what()};
    }
    const render::PixelRect rect = render::crop_pixels(settings);
    if (head.width != rect.width() || head.height != rect.height())
        return {State::OtherSize, "has " + std::to_string(head.width) + "x" + std::to_string(head.height) + " pixels, not " +
                                      std::to_string(rect.width()) + "x" + std::to_string(rect.height())};
    if (head.note.empty()) return {State::NoRecipe, "does not say with which settings it was made"};
    if (head.note != note && head.note != note + kUnfinished)
        return {State::OtherRecipe, "was made with other settings or from another scene"};
    // With a deadline, a run that is started again would make such a picture no better.
    if (head.note == note + kUnfinished && settings.deadline_s == 0)
        return {State::Broken, Error(file.string(), "was stopped before it was finished").what()};
    return {State::Same, {}};
}

}  // namespace occam::command

// The input is an image in memory, as it lies in a GLB.
#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/fuzz/door.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    occam::Scene scene;
    occam::Texture texture;
    const auto* first = reinterpret_cast<const std::byte*>(data);
    texture.encoded = std::make_shared<const std::vector<std::byte>>(first, first + size);
    occam::TextureUse use;
    use.texture = scene.add(std::move(texture));
    occam::TextureStore store(std::size_t(16) << 20);
    store.prepare(scene);
    store.sample(use, {0.3f, 0.7f}, 0.1f);
    return 0;
}

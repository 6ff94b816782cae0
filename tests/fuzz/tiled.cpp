// The input is an image file on the disk, of which tiles are read if it says that `occam texture` has made it.
#include "io/texture/texture_store.h"
#include "scenegraph/scene.h"
#include "tests/fuzz/door.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    occam::Scene scene;
    occam::Texture texture;
    texture.path = occam::fuzz::write_file("a.tx", occam::fuzz::text_of(data, size));
    occam::TextureUse use;
    use.texture = scene.add(std::move(texture));
    occam::TextureStore store(std::size_t(16) << 20);
    store.prepare(scene);
    for (const float width : {0.0f, 0.003f, 0.1f, 1.0f})
        for (int i = 0; i < 8; ++i) store.sample(use, {0.13f * float(i), 0.9f * float(i)}, width);
    return 0;
}

#include <cstdio>

#include "arguments.h"
#include "base/printable.h"
#include "io/output_file.h"
#include "io/texture/decode.h"
#include "io/texture/tiled_file.h"

namespace occam::command {

int run(const TextureArguments& a)
{
    check_output(a.out);
    refuse_inputs({{a.out}}, {{a.image}});
    remove_unfinished({{a.out}});
    Texture texture;
    texture.path = a.image;
    texture.role = a.is_data ? TextureRole::Data : TextureRole::Color;
    const MipImage image = TextureSource(texture).decode(0);
    if (const std::size_t texels = image.clamped_texels())
        std::fprintf(stderr, "occam: %s: texels that are not finite numbers, or above 65504, were clamped: %zu\n",
                     printable_line(a.image.string()).c_str(), texels);
    TiledFile::write(image, texture.role, a.out);
    return 0;
}

}  // namespace occam::command

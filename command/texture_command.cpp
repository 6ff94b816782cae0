#include <cstdio>

#include "arguments.h"
#include "base/error.h"
#include "base/printable.h"
#include "interrupt.h"
#include "io/output_file.h"
#include "io/texture/decode.h"
#include "io/texture/tiled_file.h"

namespace occam::command {

namespace {

// A file that is there is replaced only if it is one that this command makes: the two arguments are easily confused.
void refuse_other_files(const std::filesystem::path& out)
{
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(out, ignored) || is_written_directly(out)) return;
    Texture there;
    there.path = out;
    bool is_ours = false;
    try {
        is_ours = TextureSource(there).is_tiled_file();
    } catch (const Error&) {
        // It is no image.
    }
    if (!is_ours) throw Error(out.string(), "is there already, and occam texture has not made it, so it is not replaced");
}

}  // namespace

int run(const TextureArguments& a)
{
    outlive_readers();  // the file is what is made
    check_output(a.out);
    refuse_inputs({{a.out}}, {{a.image}});
    refuse_other_files(a.out);
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

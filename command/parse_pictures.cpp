// The options of `occam compare` and `occam texture`.
#include "option_kinds.h"

namespace occam::command {
namespace {

void add_limit(CLI::App& app, const std::string& name, std::optional<double>& limit, const std::string& what)
{
    add_amount(app, name, what, [&limit](double v) { limit = v; });
}

}  // namespace

CLI::App& add_compare(CLI::App& all, CompareArguments& a)
{
    CLI::App& app = *all.add_subcommand("compare", "Measure how far two pictures are apart");
    app.add_option("A", a.a, "Picture to judge")->required()->type_name("");
    app.add_option("B", a.b, "Reference")->required()->type_name("");
    app.add_flag("--json", a.json, "All common layers as JSON");
    app.add_option("--layer", a.layer,
                   "Layer of the limits and the heat map; beauty: also beauty.A, its alpha, for the limits [beauty]")
        ->type_name("NAME");
    CLI::Option* heat = app.add_option("--heat", a.heat, "Write a map of the differences")->type_name("FILE");
    add_amount(app, "--heat-scale", "Difference that is shown as white; 0: the largest [0]", [&](double v) {
        a.heat_scale = v;
    })->needs(heat);
    add_limit(app, "--max-mse", a.max_mse, "Exit code 1 if the mean squared error is larger");
    add_limit(app, "--max-rmse", a.max_rmse, "The same for the root mean squared error");
    add_limit(app, "--max-rel-mse", a.max_rel_mse, "The same for the relative mean squared error");
    add_limit(app, "--max-error", a.max_error, "The same for the largest difference");
    add_limit(app, "--max-p999", a.max_p999, "The same for the 99.9th percentile");
    add_limit(app, "--min-psnr", a.min_psnr, "Exit code 1 if the PSNR is smaller, dB");
    app.footer("Example: occam compare out.exr reference.exr --heat heat.png --max-rmse 0.01");
    return app;
}

CLI::App& add_texture(CLI::App& all, TextureArguments& texture)
{
    CLI::App& command = *all.add_subcommand("texture", "Make an image a file of tiles, of which scenes read what they need");
    command.add_option("IMAGE", texture.image, "Image to read")->required()->type_name("");
    command.add_option("OUT", texture.out, "File to write, an OpenEXR file of any name")->required()->type_name("");
    command.add_flag("--data", texture.is_data, "The texels are no colours: a normal map, roughness, a displacement");
    command.footer(
        "A texture that does not fit into --texture-memory is made smaller. One that is such a file is read tile by\n"
        "tile instead, and the picture stays as it is. Example: occam texture wood.png wood.tx");
    return command;
}

}  // namespace occam::command

// The options of `occam compare`.
#include "option_kinds.h"

namespace occam::command {
namespace {

void add_limit(CLI::App& app, const std::string& name, std::optional<double>& limit, const std::string& what)
{
    add_amount(app, name, what, [&limit](double v) { limit = v; });
}

}  // namespace

void add_compare(CLI::App& app, CompareArguments& a)
{
    app.add_option("A", a.a, "Picture to judge")->required()->type_name("");
    app.add_option("B", a.b, "Reference")->required()->type_name("");
    app.add_flag("--json", a.json, "All common layers as JSON");
    app.add_option("--layer", a.layer, "Layer of the limits and the heat map [beauty]")->type_name("NAME");
    CLI::Option* heat = app.add_option("--heat", a.heat, "Write a map of the differences")->type_name("FILE");
    add_amount(app, "--heat-scale", "Difference that is shown as white [the largest]", [&](double v) {
        a.heat_scale = v;
    })->needs(heat);
    add_limit(app, "--max-mse", a.max_mse, "Exit code 1 if the mean squared error is larger");
    add_limit(app, "--max-rmse", a.max_rmse, "The same for the root mean squared error");
    add_limit(app, "--max-rel-mse", a.max_rel_mse, "The same for the relative mean squared error");
    add_limit(app, "--max-error", a.max_error, "The same for the largest difference");
    add_limit(app, "--max-p999", a.max_p999, "The same for the 99.9th percentile");
    add_limit(app, "--min-psnr", a.min_psnr, "Exit code 1 if the PSNR is smaller, dB");
}

}  // namespace occam::command

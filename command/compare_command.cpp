#include <algorithm>
#include <cstdio>

#include "arguments.h"
#include "base/printable.h"
#include "interrupt.h"
#include "io/output_file.h"
#include "render/compare.h"

namespace occam::command {
namespace {

void print(const render::Difference& d)
{
    if (d.has_other_channels) {
        std::printf("%s: cannot be compared: it has different channels in the two pictures\n",
                    printable_line(d.layer).c_str());
        return;
    }
    std::printf("%s: mse %.6g, rmse %.6g, rel-mse %.6g, psnr %.2f dB, max %.6g, p99.9 %.6g", printable_line(d.layer).c_str(),
                d.mse, d.rmse, d.rel_mse, d.psnr, d.max, d.p999);
    if (d.incomparable) std::printf(", %llu pixels cannot be compared", static_cast<unsigned long long>(d.incomparable));
    std::printf("\n");
}

// Reports the limits that are exceeded; a picture with pixels that cannot be compared exceeds all of them.
bool meets_limits(const CompareArguments& a, const render::Difference& d)
{
    bool all = true;
    const auto check = [&](const char* name, double value, const std::optional<double>& limit, bool at_most) {
        if (!limit) return;
        const bool holds = at_most ? value <= *limit : value >= *limit;
        if (!holds)
            std::fprintf(stderr, "occam: %s is %g, the limit is %g (%s)\n", name, value, *limit,
                         printable_line(d.layer).c_str());
        all &= holds;
    };
    check("mse", d.mse, a.max_mse, true);
    check("rmse", d.rmse, a.max_rmse, true);
    check("rel-mse", d.rel_mse, a.max_rel_mse, true);
    check("max error", d.max, a.max_error, true);
    check("p99.9", d.p999, a.max_p999, true);
    check("psnr", d.psnr, a.min_psnr, false);
    if (d.incomparable == 0) return all;
    std::fprintf(stderr, "occam: %llu pixels cannot be compared (%s)\n", static_cast<unsigned long long>(d.incomparable),
                 printable_line(d.layer).c_str());
    return false;
}

}  // namespace

int run(const CompareArguments& a)
{
    if (!a.heat.empty()) {
        Image::check_writable(a.heat);
        const std::filesystem::path inputs[] = {a.a, a.b};
        refuse_inputs({&a.heat, 1}, inputs);
        remove_unfinished({&a.heat, 1});
    }
    const Image picture = Image::read(a.a), reference = Image::read(a.b);
    const auto differences = render::compare(picture, reference);
    const auto judged = std::find_if(differences.begin(), differences.end(),
                                     [&](const render::Difference& d) { return d.layer == a.layer; });
    if (judged != differences.end() && judged->has_other_channels) render::compare(picture, reference, a.layer);  // throws
    if (!a.heat.empty()) outlive_readers();
    if (a.json) std::fputs(render::to_json(differences).c_str(), stdout);
    else std::for_each(differences.begin(), differences.end(), print);

    if (judged == differences.end() && (a.has_limit() || !a.heat.empty()))
        throw Error(a.a.string(), "has no such layer in common with " + a.b.string(), a.layer);
    if (!a.heat.empty()) {
        const double scale = a.heat_scale > 0 ? a.heat_scale : judged->max;
        render::heat_map(picture, reference, a.layer, scale).write(a.heat, {.tonemap = Tonemap::None});
    }
    if (!a.has_limit()) return 0;
    bool holds = meets_limits(a, *judged);
    // What a picture covers is a part of it. Its alpha has figures of its own.
    if (a.layer == CompareArguments().layer)
        for (const render::Difference& d : differences)
            if (d.layer == render::kAlphaOfBeauty) holds = meets_limits(a, d) && holds;
    return holds ? 0 : 1;
}

}  // namespace occam::command

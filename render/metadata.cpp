#include "render/metadata.h"

#include <algorithm>
#include <ctime>
#include <glm/matrix.hpp>

#include "base/maths.h"
#include "render/version.h"

namespace occam::render {
namespace {

// Returns a matrix as OpenEXR has it: GLM's columns lie in memory as OpenEXR's rows do.
std::array<float, 16> rows_of(const Mat4d& m)
{
    std::array<float, 16> out{};
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) out[std::size_t(4 * c + r)] = static_cast<float>(m[c][r]);
    return out;
}

// Returns the coordinates of the display window, (0, 0) at its upper left and (1, 1) at its lower right, of points in
// OpenEXR's axes of the camera. What is farther away has a larger z.
Mat4d ndc_from_camera(const CameraLens& lens, double aspect)
{
    const double half = lens.orthographic ? std::max(double(lens.height) * 0.5, 1e-30) : double(maths::tan(lens.fov * 0.5f));
    Mat4d m(0.0);
    m[0][0] = 0.5 / (half * aspect);
    m[1][1] = -0.5 / half;
    m[2][2] = 1;
    if (lens.orthographic) {
        m[3] = {0.5, 0.5, 0, 1};
    } else {
        m[2] = {0.5, 0.5, 1, 1};
        m[3][2] = -1;
    }
    return m;
}

// Adds the local time, and the seconds from it to universal time.
void add_date(std::vector<Attribute>& attributes)
{
    const std::time_t now = std::time(nullptr);
    std::tm local{};
    char text[32] = "";
    if (!localtime_r(&now, &local) || std::strftime(text, sizeof text, "%Y:%m:%d %H:%M:%S", &local) == 0) return;
    attributes.push_back({"capDate", std::string(text)});
    attributes.push_back({"utcOffset", static_cast<float>(-local.tm_gmtoff)});
}

}  // namespace

void describe(Image& image, const Camera& camera, const Settings& settings, const FrameStats& stats)
{
    image.is_light = settings.view == View::Beauty;
    Mat4d looking_along_z(1.0);  // OpenEXR's camera space is left-handed
    looking_along_z[2][2] = -1;
    const Mat4d camera_from_world = looking_along_z * glm::inverse(camera.world_from_camera);
    const double aspect = double(settings.width) / settings.height;
    image.attributes.push_back({"worldToCamera", rows_of(camera_from_world)});
    image.attributes.push_back({"worldToNDC", rows_of(ndc_from_camera(camera.lens, aspect) * camera_from_world)});
    image.attributes.push_back(
        {"chromaticities", std::array<float, 8>{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f}});
    const std::string made = stats.complete ? "" : "stopped at " + std::to_string(stats.image.least_samples) + " of ";
    image.attributes.push_back({"comments", std::string("Occam ") + kVersion + ", " + made + std::to_string(settings.spp) +
                                                " samples a pixel, seed " + std::to_string(settings.seed)});
    add_date(image.attributes);
}

}  // namespace occam::render

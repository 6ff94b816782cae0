// What the fuzz targets found, mended since: each as small as it came to be.
#include <gtest/gtest.h>

#include "occam/occam.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

// Loads and renders, or is refused: either is right.
void pass_door(const std::filesystem::path& file)
{
    try {
        Scene scene = load(file);
        scene.refit();
        Renderer renderer({.threads = 1});
        renderer.render(scene, Camera::framing(scene.bounds()), {.width = 32, .height = 24, .spp = 1});
    } catch (const Error&) {
        return;
    }
}

// Read past the end of an array: creases beside vertices of two faces, at a border.
TEST(FuzzFindings, ObjCreasesBesideAVertexOfTwoFaces)
{
    TempFolder folder;
    pass_door(folder.write("scene.obj",
                           "v -0.5 0 -1.75\nv 0 0 -1.75\nv 0 -0.5 -1.75\nv 0.5 0 -1.75\nv -0.5 0 -0.75\nv 0 0 -0.75\n"
                           "v 0 -0.5 -0.75\nv 0.5 0 -0.75\nf 1 2 3 7 6 5\nf 8 6 7 3 2 4\nt crease 2/1/0 1 2 5.0\n"
                           "t crease 2/1/0 2 6 5.0\nt crease 2/1/0 6 5 5.0\nt interpolateboundary 1/0/0 1\n"));
}

}  // namespace
}  // namespace occam::test

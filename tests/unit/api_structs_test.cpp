// Structs of the API are filled by the names of a few of their members. With the warnings of this project, which are errors,
// that needs an initializer for each of the others.
#include <gtest/gtest.h>

#include <cmath>

#include "occam/occam.h"
#include "tests/support/temp_folder.h"

namespace occam::test {
namespace {

TEST(ApiStructs, AreFilledByTheNamesOfAFewMembers)
{
    const Cage cage{.name = "sheet"};
    EXPECT_TRUE(cage.positions.empty() && cage.skin.sets == 0 && !cage.displacement);
    const OnDemandCage on_demand{.name = "later"};
    EXPECT_TRUE(on_demand.bounds.is_empty() && !on_demand.make);
    const Material chrome{.metallic = 1};
    EXPECT_TRUE(chrome.name.empty() && !chrome.base_color_texture);
    EXPECT_TRUE(Texture{.path = "a.png"}.pixels.empty());
    EXPECT_TRUE(std::holds_alternative<PointLight>(Light{.name = "lamp"}.kind));
    EXPECT_EQ(Camera{.world_from_camera = Mat4d(1)}.lens.radius, 0);
    EXPECT_TRUE(Clip{.name = "walk"}.channels.empty() && Skin{.name = "skin"}.joints.empty());
    EXPECT_TRUE(Channel{.width = 4}.times.empty() && MorphTarget{.name = "smile"}.positions.empty());
    EXPECT_TRUE(UvSet{.values = {Vec2f(0)}}.indices.empty());
    EXPECT_FALSE(TextureUse{.nearest = true}.texture);
    // The first member may be left out, too.
    EXPECT_TRUE(Cage{.scheme = Scheme::Bilinear}.name.empty() && OnDemandCage{.bounds = {}}.name.empty());
    EXPECT_TRUE(Light{.kind = PointLight{}}.name.empty() && Clip{.channels = {}}.name.empty());
    EXPECT_TRUE(Skin{.joints = {}}.name.empty() && MorphTarget{.positions = {}}.name.empty());
    EXPECT_TRUE(Texture{.width = 1}.path.empty() && UvSet{.indices = {}}.values.empty());
    EXPECT_FALSE(Displacement{.scale = 1}.texture);
}

TEST(ApiImages, WithoutTheLayerThatAFormatHoldsAreRefused)
{
    const TempFolder folder;
    Image image(4, 4);
    image.add_layer("depth", {"Z"}).pixels.assign(16, 1);
    for (const char* name : {"a.png", "a.jpg", "a.tif", "a.hdr"})
        EXPECT_THROW(image.write(folder.path() / name), Error) << name;
    image.write(folder.path() / "a.exr");
    image.add_layer("beauty", {"R", "G", "B"}).pixels.assign(48, 1);
    image.write(folder.path() / "a.png");
}

}  // namespace
}  // namespace occam::test

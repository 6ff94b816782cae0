// Tests of the materials of an OBJ, with separate maps for opacity, roughness, metalness and normals.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "scenegraph/scene.h"
#include "tests/support/import_errors.h"
#include "tests/support/temp_folder.h"

namespace occam {
namespace {

using test::TempFolder;
using test::warns;

// Returns a PPM of one texel.
std::string texel(const char* rgb) { return "P6\n1 1\n255\n" + std::string(rgb, 3); }

struct Loaded {
    TempFolder folder;
    Scene scene;
    Material material;

    explicit Loaded(const std::string& mtl)
    {
        folder.write("grey.ppm", texel("\x80\x80\x80"));
        folder.write("blue.ppm", texel("\x80\x80\xff"));
        folder.write("m.mtl", "newmtl m\n" + mtl);
        scene = load(folder.write("o.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
        scene.for_each_placement([&](NodeId, const Node& node, const Mat4d&) {
            for (const CageId id : node.cages) material = scene.material(scene.cage(id).cage.materials.at(0));
        });
    }
    std::string file(const TextureUse& use) const
    {
        return use ? scene.texture(use.texture).path.filename().string() : std::string();
    }
    TextureRole role(const TextureUse& use) const { return scene.texture(use.texture).role; }
};

// Each reading of such a library takes milliseconds.
TEST(ImportMtl, ALibraryThatIsNamedThousandsOfTimesIsReadOnce)
{
    const TempFolder folder;
    std::string mtl, obj;
    for (int i = 0; i < 2000; ++i) mtl += "newmtl m" + std::to_string(i) + "\nKd 1 0 0\n";
    for (int i = 0; i < 20'000; ++i) obj += "mtllib m.mtl\n";
    folder.write("m.mtl", mtl);
    const Scene scene = load(folder.write("o.obj", obj + "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m1999\nf 1 2 3\n"));
    EXPECT_EQ(scene.material(test::only_cage(scene).materials.at(0)).name, "m1999");
}

// If each option searched the blanks, there would be 10^11 steps.
TEST(ImportMtl, BlanksAtTheEndOfALineAreSearchedOnce)
{
    std::string line = "map_Kd";
    for (int i = 0; i < 100'000; ++i) line += " -boost 1";
    const Loaded loaded(line + " blue.ppm" + std::string(1'000'000, ' ') + "\n");
    EXPECT_EQ(loaded.file(loaded.material.base_color_texture), "blue.ppm");
}

// The format's illumination model 1 is Lambertian.
TEST(ImportMtl, TheModelWithoutHighlightsReflectsNoLight)
{
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nKs 0 0 0\nillum 1\n").material.specular, 0);
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nKs 1 1 1\nillum 1\n").material.specular, 0);
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nillum 2\n").material.specular, 1);
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\n").material.specular, 1) << "the file does not say";
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nPr 0.4\nillum 1\n").material.specular, 1) << "it has a roughness";
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nPm 1\nillum 1\n").material.specular, 1) << "it is a metal";
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nmap_Pr grey.ppm\nillum 1\n").material.specular, 1);
}

TEST(ImportMtl, WithoutAnIndexOfRefractionTheDefaultHolds)
{
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\n").material.ior, 1.5f);
    EXPECT_EQ(Loaded("Kd 0.5 0.5 0.5\nNi 1\n").material.ior, 1);
    EXPECT_EQ(Loaded("Ni 1.33\nnewmtl other\nKd 1 1 1\n").material.ior, 1.33f);
}

TEST(ImportMtl, ARoughnessOfZeroIsSmooth)
{
    EXPECT_EQ(Loaded("Kd 0 0 0\nPr 0\nPm 0\nNi 1.5\n").material.roughness, 0);
    EXPECT_EQ(Loaded("Ns 10\nPr 0\n").material.roughness, 0);
    EXPECT_EQ(Loaded("Pr 0\nillum 1\n").material.specular, 1);
    EXPECT_EQ(Loaded("Pm 0\n").material.roughness, Material().roughness) << "it says nothing about roughness";
    EXPECT_EQ(Loaded("Pr 0\nmap_Pr grey.ppm\n").material.roughness, 1) << "the map alone";
}

TEST(ImportMtl, MetalsWithoutARoughnessHaveThatOfTheirHighlight)
{
    const float of_highlight = Loaded("Ns 100\n").material.roughness;
    EXPECT_LT(of_highlight, Material().roughness);
    EXPECT_EQ(Loaded("Ns 100\nPm 1\n").material.roughness, of_highlight);
    EXPECT_EQ(Loaded("Ns 100\nPm 1\n").material.metallic, 1);
    EXPECT_EQ(Loaded("Pm 1\n").material.roughness, Material().roughness) << "the file does not say";
    EXPECT_EQ(Loaded("Pm 1\n").material.metallic, 1);
    EXPECT_EQ(Loaded("Ns 100\nPm 1\nPr 0\n").material.roughness, 0);
    EXPECT_EQ(Loaded("Pr 0.25\n").material.metallic, 0);
}

TEST(ImportMtl, PartsOfAColourThatAreLeftOutEqualTheFirst)
{
    EXPECT_EQ(Loaded("Kd 0.5\nKe 2 # lamp\n").material.base_color, Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_EQ(Loaded("Kd 0.5\nKe 2 # lamp\n").material.emission, Vec3f(2));
    EXPECT_EQ(Loaded("Kd 0.6\nmap_Kd blue.ppm\n").material.base_color, Vec4f(0.6f, 0.6f, 0.6f, 1));
    EXPECT_EQ(Loaded("map_Kd blue.ppm\n").material.base_color, Vec4f(1)) << "the map alone";
}

TEST(ImportMtl, WhatCannotBeReadGetsItsDefaultAndAWarning)
{
    for (const char* color : {"spectral file.rfl", "xyz 0.1 0.2 0.3"}) {
        const Loaded loaded(std::string("Kd ") + color + "\nKe " + color + "\n");
        EXPECT_EQ(loaded.material.base_color, Vec4f(1));
        EXPECT_EQ(loaded.material.emission, Vec3f(0));
        EXPECT_TRUE(warns(loaded.scene, "spectra or in CIE XYZ")) << color;
        EXPECT_TRUE(warns(loaded.scene, "(m.mtl, line 2, first of 2)")) << color;
    }
    for (const char* color : {"0,5 0,5 0,5", "0.5 0.5 x", "nan nan nan", ""}) {
        const Loaded loaded(std::string("Kd ") + color + "\n");
        EXPECT_EQ(loaded.material.base_color, Vec4f(1));
        EXPECT_TRUE(warns(loaded.scene, "a colour is not made of numbers")) << color;
    }
    const Loaded values("d 0,5\nNi x\nPr\nPm nan\nillum 1x\n");
    EXPECT_EQ(values.material.specular, 1);
    EXPECT_EQ(values.material.base_color.w, 1);
    EXPECT_EQ(values.material.ior, 1.5f);
    EXPECT_EQ(values.material.roughness, Material().roughness);
    EXPECT_TRUE(warns(values.scene, "a value of a material is not a number: it is left out (m.mtl, line 2, first of 5)"));
}

TEST(ImportMtl, ValuesOutOfTheirRangeAreCountedByStatement)
{
    for (const char* line : {"Kd -0.5 0 0", "Ke 1 -2 0", "d 1e30", "d -0.5", "Pr 7", "Pm 3e38", "Pm -3", "Pc 2", "Pcr -0.25",
                             "Ns 1e30", "Ns -4", "Ni 3e38", "Ni -2"}) {
        const Loaded loaded(std::string(line) + "\n");
        const std::string statement(line, std::string(line).find(' '));
        EXPECT_TRUE(warns(loaded.scene, "a value of " + statement + " is out of range (material m)")) << line;
    }
    for (const char* line :
         {"Kd 0.5 0 0", "Ke 100 2 0", "d 0.5", "Pr 1", "Pm 0", "Pc 1", "Pcr 0", "Ns 1000", "Ni 0", "Ni 2.4", ""})
        EXPECT_TRUE(Loaded(std::string(line) + "\n").scene.warnings.empty()) << line;
}

TEST(ImportMtl, OpacityWithAHaloKeepsItsNumber)
{
    const Loaded loaded("d -halo 0.25\n");
    EXPECT_EQ(loaded.material.base_color.w, 0.25f);
    EXPECT_TRUE(warns(loaded.scene, "-halo"));
}

TEST(ImportMtl, NumbersOfOptionsThatAreNotFiniteGetTheirDefaultsAndAWarning)
{
    for (const char* options : {"-o inf nan 0 -mm 0 1", "-o 1e999 -nan -1e999 -mm nan inf", "-s inf -mm 0 1", "-bm +inf"}) {
        const Loaded loaded(std::string("map_Kd ") + options + " blue.ppm\n");
        EXPECT_EQ(loaded.file(loaded.material.base_color_texture), "blue.ppm") << options;
        EXPECT_EQ(loaded.material.base_color_texture.scale, Vec2f(1)) << options;
        EXPECT_EQ(loaded.material.base_color_texture.offset, Vec2f(0)) << options;
        EXPECT_TRUE(warns(loaded.scene,
                          "a value of an image's option is not a finite number: the default is used (m.mtl, "
                          "line 2"))
            << options;
    }
}

TEST(ImportMtl, OptionsThatWouldChangeTheImageAreLeftOutWithAWarning)
{
    for (const char* options : {"-mm 0.2", "-mm 0 0.5", "-s 2 -t 0 0.1"}) {
        const Loaded loaded(std::string("map_Kd ") + options + " blue.ppm\n");
        EXPECT_EQ(loaded.file(loaded.material.base_color_texture), "blue.ppm") << options;
        EXPECT_TRUE(warns(loaded.scene, "the options -mm and -t of images")) << options;
    }
    for (const char* options : {"-mm 0 1", "-mm 0.0", "-t 0 -s 2", "-boost 2"})
        EXPECT_TRUE(Loaded(std::string("map_Kd ") + options + " blue.ppm\n").scene.warnings.empty()) << options;
}

TEST(ImportMtl, NumbersOfOptionsMayBeLeftOut)
{
    const auto map = [](const std::string& options) {
        const Loaded loaded("map_Kd " + options + "\n");
        EXPECT_EQ(loaded.file(loaded.material.base_color_texture), "blue.ppm") << options;
        EXPECT_TRUE(loaded.scene.warnings.empty()) << options;
        return loaded.material.base_color_texture;
    };
    EXPECT_EQ(map("-s 2 3 blue.ppm").scale, Vec2f(2, 3));
    EXPECT_EQ(map("-s 2 blue.ppm").scale, Vec2f(2, 1));
    EXPECT_EQ(map("-o .5 blue.ppm").offset, Vec2f(0.5f, 0));
    EXPECT_EQ(map("-o +.5 .25 -s 2 blue.ppm").offset, Vec2f(0.5f, -0.25f));
    EXPECT_EQ(map("-t 0 -mm 0 -bm blue.ppm").scale, Vec2f(1));
    EXPECT_EQ(map("-cc on -texres 512 -imfchan m -blendu off -s 2 2 1 blue.ppm # small").scale, Vec2f(2));
    EXPECT_EQ(map("-clamp blue.ppm").wrap_s, TextureUse::Wrap::Clamp);
    EXPECT_EQ(map("-clamp off blue.ppm").wrap_s, TextureUse::Wrap::Repeat);

    TempFolder folder;
    folder.write("2", texel("abc"));
    folder.write("m.mtl", "newmtl m\nmap_Kd -s 2 2 2\n");
    const Scene scene = load(folder.write("o.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
    EXPECT_TRUE(scene.warnings.empty()) << "the last word is the name";
    EXPECT_EQ(scene.counts().textures, 1u);
}

TEST(ImportMtl, LinesMayEndWithACarriageReturnAlone)
{
    const Loaded loaded("Kd 0.5\rPr 0.25\rmap_Pm -s 2 grey.ppm\r");
    EXPECT_EQ(loaded.material.base_color, Vec4f(0.5f, 0.5f, 0.5f, 1));
    EXPECT_EQ(loaded.material.roughness, 0.25f);
    EXPECT_EQ(loaded.material.metallic_texture.scale, Vec2f(2, 1));
}

TEST(ImportMtl, NamesMayBeFollowedByCommentsOrHoldTheirSign)
{
    const TempFolder folder;
    folder.write("m.mtl", "newmtl red # a comment\nKd 1 0 0\nnewmtl blue #2\nKd 0 0 1\nnewmtl  blue #3\nKd 0 0 0.5\n");
    const Scene scene = load(folder.write("o.obj",
                                          "mtllib m.mtl # library\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
                                          "usemtl red # face\nf 1 2 3\nusemtl blue #2\nf 2 3 1\n"
                                          "usemtl blue #3\nf 3 2 1\n"));
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    const Cage& cage = test::only_cage(scene);
    ASSERT_EQ(cage.materials.size(), 3u);
    EXPECT_EQ(scene.material(cage.materials[0]).base_color, Vec4f(1, 0, 0, 1));
    EXPECT_EQ(scene.material(cage.materials[1]).base_color, Vec4f(0, 0, 1, 1));
    EXPECT_EQ(scene.material(cage.materials[2]).base_color, Vec4f(0, 0, 0.5f, 1));
}

TEST(ImportMtl, AnAlphaMapOfItsOwnIsData)
{
    const Loaded loaded("map_Kd blue.ppm\nmap_d grey.ppm\n");
    EXPECT_EQ(loaded.material.alpha_mode, AlphaMode::Blend);
    ASSERT_EQ(loaded.file(loaded.material.alpha_texture), "grey.ppm");
    EXPECT_EQ(loaded.role(loaded.material.alpha_texture), TextureRole::Data);
    EXPECT_EQ(loaded.role(loaded.material.base_color_texture), TextureRole::Color);
}

TEST(ImportMtl, AnAlphaMapThatIsTheBaseColoursImageIsItsAlpha)
{
    for (const std::string name : {"blue.ppm", "./blue.ppm", ".\\blue.ppm", "blue.ppm # its alpha"}) {
        const Loaded loaded("map_Kd blue.ppm\nmap_d " + name + "\n");
        EXPECT_EQ(loaded.material.alpha_mode, AlphaMode::Blend) << name;
        EXPECT_FALSE(loaded.material.alpha_texture) << name;
    }
}

TEST(ImportMtl, AMaterialWithoutANameChangesNoOther)
{
    const Loaded loaded("Kd 1 0 0\nnewmtl\nKd 0 1 0\nmap_Kd blue.ppm\n");
    EXPECT_EQ(loaded.material.base_color, Vec4f(1, 0, 0, 1));
    EXPECT_FALSE(loaded.material.base_color_texture);
    EXPECT_TRUE(warns(loaded.scene, "a material has no name: it is left out (m.mtl, line 3)"));
}

TEST(ImportMtl, ImagesAreSoughtBesideTheirLibrary)
{
    for (const std::string name : {"sub/m.mtl", "sub\\m.mtl"}) {
        const TempFolder folder;
        std::filesystem::create_directory(folder.path() / "sub");
        const auto beside = folder.write("sub/t.ppm", texel("\x80\x80\x80"));
        folder.write("t.ppm", texel("\x80\x80\xff"));
        const auto above = folder.write("above.ppm", texel("\x80\x80\xff"));
        folder.write("sub/m.mtl", "newmtl m\nmap_Kd t.ppm\nmap_Ke above.ppm\n");
        const Scene scene = load(
            folder.write("o.obj", "mtllib " + name + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"));
        EXPECT_TRUE(scene.warnings.empty()) << name;
        const Material& m = scene.material(test::only_cage(scene).materials.at(0));
        EXPECT_TRUE(std::filesystem::equivalent(scene.texture(m.base_color_texture.texture).path, beside)) << name;
        EXPECT_TRUE(std::filesystem::equivalent(scene.texture(m.emission_texture.texture).path, above)) << name;
    }
}

TEST(ImportMtl, MapsOfRoughnessAndMetalnessMultiplyTheirFactors)
{
    const Loaded alone("map_Pr grey.ppm\nmap_Pm -s 2 3 1 blue.ppm\n");
    EXPECT_EQ(alone.file(alone.material.roughness_texture), "grey.ppm");
    EXPECT_EQ(alone.file(alone.material.metallic_texture), "blue.ppm");
    EXPECT_EQ(alone.material.metallic_texture.scale, Vec2f(2, 3));
    EXPECT_EQ(alone.material.roughness, 1);
    EXPECT_EQ(alone.material.metallic, 1);
    const Loaded both("Pr 0.5\nPm 0.25\nmap_Pr grey.ppm\nmap_Pm grey.ppm\n");
    EXPECT_EQ(both.material.roughness, 0.5f);
    EXPECT_EQ(both.material.metallic, 0.25f);
}

TEST(ImportMtl, NormalMapsComeByNormOrAsAColouredBumpMap)
{
    const Loaded norm("norm blue.ppm\n"), bump("map_Bump -bm 0.5 blue.ppm\n");
    EXPECT_EQ(norm.file(norm.material.normal_texture), "blue.ppm");
    EXPECT_EQ(bump.file(bump.material.normal_texture), "blue.ppm");
    EXPECT_EQ(bump.material.normal_scale, 0.5f);
}

TEST(ImportMtl, ABumpMapWithoutColourHoldsHeights)
{
    const Loaded loaded("map_Bump -bm 0.25 grey.ppm\n"), bump("bump grey.ppm\n");
    EXPECT_FALSE(loaded.material.normal_texture);
    EXPECT_EQ(loaded.file(loaded.material.bump_texture), "grey.ppm");
    EXPECT_EQ(loaded.role(loaded.material.bump_texture), TextureRole::Data);
    EXPECT_EQ(loaded.material.bump_scale, 0.25f);
    EXPECT_EQ(bump.file(bump.material.bump_texture), "grey.ppm");
    EXPECT_EQ(bump.material.bump_scale, 1);
}

TEST(ImportMtl, EachMissingMapIsNamed)
{
    const Loaded loaded("Kd 1 1 1\nmap_Kd none.png\nmap_Ke none2.png\nnorm none2.png\n");
    EXPECT_TRUE(warns(loaded.scene, "image file is missing (none.png)"));
    EXPECT_TRUE(warns(loaded.scene, "image file is missing (none2.png, number of uses: 2)"));
    EXPECT_EQ(loaded.scene.warnings.size(), 2u);
    EXPECT_EQ(loaded.material.base_color, Vec4f(0.5f, 0.5f, 0.5f, 1)) << "grey";
    EXPECT_EQ(loaded.material.emission, Vec3f(0)) << "what would shine evenly without its image does not";
    EXPECT_FALSE(loaded.material.normal_texture);
}

TEST(ImportMtl, PathsMayHaveBackslashes)
{
    const Loaded loaded("map_Kd .\\blue.ppm\n");
    EXPECT_EQ(loaded.file(loaded.material.base_color_texture), "blue.ppm");
    EXPECT_TRUE(loaded.scene.warnings.empty());
}

TEST(ImportMtl, AMaterialWithoutAColourIsWhite)
{
    EXPECT_EQ(Loaded("Ns 10\n").material.base_color, Vec4f(1));
    EXPECT_TRUE(Loaded("Ns 10\n").scene.warnings.empty());
    EXPECT_EQ(Loaded("d 0.5\n").material.base_color, Vec4f(1, 1, 1, 0.5f));
    EXPECT_EQ(Loaded("Kd 0 0 0\n").material.base_color, Vec4f(0, 0, 0, 1)) << "this one is given";
    EXPECT_EQ(Loaded("map_Kd none.png\n").material.base_color, Vec4f(0.5f, 0.5f, 0.5f, 1)) << "grey";
}

}  // namespace
}  // namespace occam

#include "io/import/import.h"

#include <algorithm>
#include <new>

#include "io/import/gltf.h"
#include "io/import/obj.h"
#include "io/import/polygon_files.h"
#include "io/import/report.h"

namespace occam {

namespace import {

void finish(Scene& scene, const Report& report)
{
    if (report.is_strict() && !scene.warnings.empty()) throw Error(report.name(), scene.warnings.front());
    std::vector<std::string> lines = report.lines();
    scene.warnings.insert(scene.warnings.begin(), lines.begin(), lines.end());
}

namespace {

using Loader = Scene (*)(const std::filesystem::path&, const LoadOptions&);

Loader loader_of(const std::filesystem::path& file)
{
    std::string extension = file.extension().string();
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    if (extension == ".gltf" || extension == ".glb") return load_gltf;
    if (extension == ".obj") return load_obj;
    if (extension == ".ply") return load_ply;
    if (extension == ".off") return load_off;
    if (extension == ".stl") return load_stl;
    throw Error(file.string(), "not a scene file that is known: .gltf, .glb, .obj, .ply, .off or .stl", extension);
}

void require_variant(const Scene& scene, const std::filesystem::path& file, const std::string& name)
{
    if (name.empty() || std::find(scene.variants.begin(), scene.variants.end(), name) != scene.variants.end()) return;
    std::string known;
    for (const std::string& variant : scene.variants) known += (known.empty() ? "it has " : ", ") + variant;
    throw Error(file.string(), "has no variant of that name; " + (known.empty() ? "it has none" : known), name);
}

}  // namespace

}  // namespace import

Scene load(const std::filesystem::path& file, const LoadOptions& options)
{
    const import::Loader loader = import::loader_of(file);
    try {
        Scene scene = loader(file, options);
        import::require_variant(scene, file, options.variant);
        return scene;
    } catch (const Error& error) {
        if (!error.file().empty()) throw;
        throw Error(file.string(), error.what());  // the file's content breaks a rule of the scene graph
    } catch (const std::bad_alloc&) {
        throw Error(file.string(), "there is not enough memory for what it declares", {}, Error::Kind::Output);
    } catch (const std::exception& error) {
        throw Error(file.string(), std::string("not readable: ") + error.what());
    }
}

}  // namespace occam

// An OBJ into a scene, beside the parser library alone: its usual reader, and its callbacks that keep nothing.

// A copy of the library of our own, so that this file needs nothing to be linked.
#define tinyobj occam_bench_tinyobj
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include "scenegraph/import/import.h"
#include "tests/bench/subjects.h"
#include "tests/bench/suites.h"
#include "tests/support/temp_folder.h"

namespace occam::bench {

void run_import(Report& report)
{
    constexpr int kRuns = 5;
    const test::TempFolder folder;
    const std::filesystem::path file = folder.path() / "waves.obj";
    write_wave_obj(file, kWaveColumns, kWaveRows);

    std::vector<double> ours, library, callbacks;
    std::size_t faces = 0, faces_of_library = 0;
    std::string warnings, errors;
    for (int i = 0; i < kRuns; ++i) {
        ours.push_back(repeat(1, [&] { faces = load(file).counts().faces; }).front());
        library.push_back(repeat(1, [&] {
                              tinyobj::attrib_t attributes;
                              std::vector<tinyobj::shape_t> shapes;
                              std::vector<tinyobj::material_t> materials;
                              tinyobj::LoadObj(&attributes, &shapes, &materials, &warnings, &errors, file.c_str(), nullptr,
                                               false);
                              faces_of_library = shapes.empty() ? 0 : shapes[0].mesh.num_face_vertices.size();
                          }).front());
        callbacks.push_back(repeat(1, [&] {
                                std::ifstream stream(file, std::ios::binary);
                                tinyobj::LoadObjWithCallback(stream, {}, nullptr, nullptr, &warnings, &errors);
                            }).front());
    }
    const double count = double(faces);
    Row row{"import", "obj, 500,000 quads with texture coordinates"};
    row.add("faces", count).add("faces_of_tinyobj", double(faces_of_library));
    row.add("megabytes", 1e-6 * double(std::filesystem::file_size(file)));
    row.add("occam_faces_per_s", per(count, ours)).add("tinyobj_faces_per_s", per(count, library));
    row.add("tinyobj_callbacks_faces_per_s", per(count, callbacks));
    row.add("time_over_tinyobj", ratios(ours, library)).add("time_over_callbacks", ratios(ours, callbacks));
    report.add(std::move(row));
}

}  // namespace occam::bench

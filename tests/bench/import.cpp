// The suite reads an OBJ and a GLB file of 100 MB into scenes, beside the parser libraries alone: tinyobjloader's usual
// reader, and its callbacks that keep nothing; and tinygltf's model, which holds the buffers as they are in the file. An STL
// file of 100 MB, whose vertices have to be joined, stands beside the reading of its bytes.

// This is our own copy of the library, so that this file needs nothing to be linked.
#define tinyobj occam_bench_tinyobj
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_gltf.h>
#include <tiny_obj_loader.h>

#include "io/import/import.h"
#include "tests/bench/harness.h"
#include "tests/bench/suites.h"
#include "tests/bench/wave_files.h"
#include "tests/support/temp_folder.h"

namespace occam::bench {

namespace {

constexpr int kRuns = 5;

void run_obj(Report& report)
{
    const test::TempFolder folder;
    const std::filesystem::path file = folder.path() / "waves.obj";
    write_wave_obj(file, 1000, 1000);

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
    Row row{"import", "obj, 1,000,000 quads with texture coordinates"};
    row.add("faces", count).add("faces_of_tinyobj", double(faces_of_library));
    row.add("megabytes", 1e-6 * double(std::filesystem::file_size(file)));
    row.add("occam_faces_per_s", per(count, ours)).add("tinyobj_faces_per_s", per(count, library));
    row.add("tinyobj_callbacks_faces_per_s", per(count, callbacks));
    row.add("time_over_tinyobj", ratios(ours, library)).add("time_over_callbacks", ratios(ours, callbacks));
    report.add(std::move(row));
}

// Reads a file into scenes, and by `peer()`, in turns.
struct Readings {
    std::vector<double> ours, peers;
    double faces = 0, megabytes = 0;

    template <class Peer>
    Readings(const std::filesystem::path& file, Peer&& peer) : megabytes(1e-6 * double(std::filesystem::file_size(file)))
    {
        for (int i = 0; i < kRuns; ++i) {
            ours.push_back(repeat(1, [&] { faces = double(load(file).counts().faces); }).front());
            peers.push_back(repeat(1, peer).front());
        }
    }
    Row row(const char* what) const
    {
        Row row{"import", what};
        row.add("faces", faces).add("megabytes", megabytes).add("occam_faces_per_s", per(faces, ours));
        return row;
    }
};

void run_glb(Report& report)
{
    const test::TempFolder folder;
    const std::filesystem::path file = folder.path() / "waves.glb";
    write_wave_glb(file, 1400, 1300);
    const Readings read(file, [&] {
        tinygltf::TinyGLTF reader;
        tinygltf::Model model;
        std::string warnings, errors;
        reader.LoadBinaryFromFile(&model, &errors, &warnings, file.string());
    });
    Row row = read.row("glb, 3,640,000 triangles with normals and texture coordinates");
    row.add("tinygltf_faces_per_s", per(read.faces, read.peers)).add("time_over_tinygltf", ratios(read.ours, read.peers));
    report.add(std::move(row));
}

void run_stl(Report& report)
{
    const test::TempFolder folder;
    const std::filesystem::path file = folder.path() / "waves.stl";
    write_wave_stl(file, 1000, 1000);
    const Readings read(file, [&] {
        std::string all(std::filesystem::file_size(file), ' ');
        std::ifstream(file, std::ios::binary).read(all.data(), static_cast<std::streamsize>(all.size()));
    });
    Row row = read.row("stl, 2,000,000 triangles");
    row.add("time_over_reading_bytes", ratios(read.ours, read.peers));
    report.add(std::move(row));
}

}  // namespace

void run_import(Report& report)
{
    run_obj(report);
    run_glb(report);
    run_stl(report);
}

}  // namespace occam::bench

#include "io/import/gltf_cage_files.h"

#include "io/import/cage_bytes.h"
#include "io/import/files.h"
#include "io/import/gltf_uri.h"
#include "io/import/obj.h"
#include "io/import/polygons.h"

namespace occam::import {

const std::string& CageFiles::canonical(const std::string& name, const std::string& where)
{
    const auto [known, is_new] = paths_.try_emplace(name);
    if (is_new) {
        const auto& path = report_.folder().find(decode_uri(name)).path;
        if (!path) throw Error(report_.name(), "the cage is not in the scene's folder: " + name, where);
        known->second = path->string();
    }
    return known->second;
}

CageId CageFiles::cage(const NodeExtras& extras, const std::string& where)
{
    const CageStyle& style = extras.style;
    Reading reading{canonical(extras.cage, where), extras.material < 0, style.scheme};
    if (without_libraries_.contains(reading.path)) reading.with_materials = false;
    if (const auto known = cages_.find({reading, style}); known != cages_.end()) return known->second;
    Cage cage;
    auto source = sources_.find(reading);
    const bool is_first = source == sources_.end();
    if (is_first) {
        cage = read(extras, reading);
        source = sources_.try_emplace(reading, Source{{}, cage.boundary, cage.face_varying}).first;
        copies_.allow_copies_of(bytes_of(cage));
    } else {
        const Cage& first = scene_.cage(source->second.cage).cage;
        copies_.charge(1, bytes_of(first), where);
        cage = first;
        cage.boundary = source->second.boundary, cage.face_varying = source->second.face_varying;
        cage.displacement.reset();
    }
    style.apply(cage);
    if (style.displacement) cage.displacement = materials_.displacement(*style.displacement, where);
    const CageId id = scene_.add(std::move(cage));
    if (is_first) source->second.cage = id;
    cages_.try_emplace({reading, style}, id);
    return id;
}

// A file without libraries gives the same cage with materials and without.
Cage CageFiles::read(const NodeExtras& extras, Reading& reading)
{
    const std::filesystem::path path(reading.path);
    Report report(path, options_.strict);
    Polygons polygons = read_obj(path, scene_, reading.with_materials, report);
    if (!polygons.has_libraries) without_libraries_.insert(reading.path), reading.with_materials = false;
    const bool is_cage = extras.style.scheme.value_or(CageStyle::Scheme::CatmullClark) != CageStyle::Scheme::None;
    // The prefix hides a scheme in the name of the cage, since the node's scheme has priority.
    if (extras.style.scheme) polygons.cage.name.insert(0, "cage ");
    Cage cage = settle(std::move(polygons), is_cage ? Subdivide::On : Subdivide::Off, report).cage;
    for (const std::filesystem::path& file : report.files()) report_.add_file(file);
    for (const std::string& line : report.lines()) scene_.warnings.push_back(extras.cage + ": " + line);
    return cage;
}

}  // namespace occam::import

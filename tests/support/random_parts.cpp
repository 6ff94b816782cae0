#include "tests/support/random_parts.h"

#include "tests/support/case_random.h"
#include "tests/support/displaced_cages.h"
#include "tests/support/made_cages.h"
#include "tests/support/random_look.h"

namespace occam::test {
namespace {

/// Triangulates every face as a fan; the result is a mesh, which is rendered as it is.
void make_triangles(Cage& cage)
{
    std::vector<std::uint32_t> corners;
    std::size_t first = 0;
    for (const std::uint32_t size : cage.face_sizes) {
        for (std::uint32_t i = 2; i < size; ++i)
            for (const std::uint32_t k : {0u, i - 1, i}) corners.push_back(cage.face_vertices[first + k]);
        first += size;
    }
    Cage triangles;
    triangles.scheme = Scheme::Triangles;
    triangles.name = cage.name;
    triangles.positions = cage.positions;
    triangles.face_vertices = corners;
    cage = std::move(triangles);
}

void shape(Cage& cage, const RandomCase& c, const RandomPart& part)
{
    if (part.has(PartFeature::Noise)) {
        CaseRandom random(c, part, PartFeature::Noise);
        const double size = random.between(0, 0.08) * cage.bounds().radius();
        for (Vec3f& p : cage.positions) p += Vec3f(random.inside_cube() * size);
    }
    if (part.has(PartFeature::Creases)) {
        CaseRandom random(c, part, PartFeature::Creases);
        const double share = random.number();
        std::size_t first = 0;
        cage.creases.clear();
        for (const std::uint32_t size : cage.face_sizes) {
            for (std::uint32_t i = 0; i < size; ++i)
                if (cage.face_vertices[first + i] < cage.face_vertices[first + (i + 1) % size] && random.number() < share)
                    cage.creases.push_back({cage.face_vertices[first + i], cage.face_vertices[first + (i + 1) % size],
                                            0.25f * float(1 + random.index(40))});
            first += size;
        }
    }
    if (part.has(PartFeature::Corners)) {
        CaseRandom random(c, part, PartFeature::Corners);
        cage.corners.clear();
        for (std::size_t n = 1 + random.index(3); n > 0; --n)
            cage.corners.push_back(
                {static_cast<std::uint32_t>(random.index(cage.positions.size())), 0.25f * float(1 + random.index(40))});
    }
    if (part.has(PartFeature::Hole))
        cage.holes = {static_cast<std::uint32_t>(CaseRandom(c, part, PartFeature::Hole).index(cage.face_sizes.size()))};
    if (part.has(PartFeature::Fin)) {
        cage.positions.push_back(cage.positions[cage.face_vertices[0]] * 1.7f);
        cage.face_sizes.push_back(3);
        cage.face_vertices.insert(cage.face_vertices.end(), {cage.face_vertices[0], cage.face_vertices[1],
                                                             static_cast<std::uint32_t>(cage.positions.size() - 1)});
    }
    if (part.has(PartFeature::Bilinear)) cage.scheme = Scheme::Bilinear;
}

Mat4d place_of(const RandomCase& c, const RandomPart& part)
{
    CaseRandom random(c.seed, part.key, 1);
    // Compilers evaluate arguments in any order.
    const double w = random.between(0.1, 1);
    const Vec4d turn = glm::normalize(Vec4d(random.inside_cube(), w));
    double scale = random.between(0.4, 1.2);
    Vec3d at = random.inside_cube() * 2.0;
    if (part.has(PartFeature::Large)) scale *= 1000, at = at * 1000.0 - Vec3d(0, 0, 5000);
    if (part.has(PartFeature::Small)) scale *= 0.001;
    at += origin_of(c);
    Trs place;
    place.translation = at;
    place.rotation = turn;
    place.scale = Vec3d(scale);
    if (part.has(PartFeature::Stretched)) place.scale = place.scale * Vec3d(1, 0.3, 1.9);
    if (part.has(PartFeature::Mirrored)) place.scale.x = -place.scale.x;
    return place.matrix();
}

}  // namespace

Vec3d origin_of(const RandomCase& c) { return c.has(SettingFeature::Far) ? Vec3d(1e5, -3e4, 7e4) : Vec3d(0); }

AddedPart add_part(Scene& scene, const RandomCase& c, const RandomPart& part)
{
    Cage cage = made_cage(part.cage);
    shape(cage, c, part);
    cage.name = part.cage + std::to_string(part.key);
    if (part.has(PartFeature::Skinned)) add_skin(cage);
    if (part.has(PartFeature::Triangles)) make_triangles(cage);
    paint(cage, scene, c, part);
    AddedPart added{.part = part, .node = {}, .joint = {}, .cage = {}, .place = place_of(c, part), .swarm = {}};
    NodeDesc desc;
    desc.name = cage.name;
    desc.matrix = added.place;
    if (part.has(PartFeature::Skinned) && !part.has(PartFeature::Triangles)) {
        Skin skin;
        for (const Mat4d& joint : bent_joints()) {
            NodeDesc bone;
            bone.matrix = added.place * joint;
            skin.joints.push_back(scene.add_node(scene.root(), bone));
        }
        added.joint = skin.joints.back();
        desc.skin = scene.add(skin);
    }
    added.cage = scene.add(std::move(cage));
    desc.cages = {added.cage};
    added.node = scene.add_node(scene.root(), desc);
    for (int k = 0; part.has(PartFeature::Instanced) && k < 3; ++k) {
        NodeDesc copy;
        copy.instance_of = added.node;
        copy.matrix = added.place;
        (*copy.matrix)[3] += added.place[static_cast<int>(k)] * 2.5;
        scene.add_node(scene.root(), copy);
    }
    for (int k = 0; c.has(SettingFeature::Swarm) && k < 40; ++k) {
        NodeDesc copy;
        copy.instance_of = added.node;
        added.swarm.push_back(scene.add_node(scene.root(), copy));
    }
    move_swarm(scene, c, added, 0);
    return added;
}

void move_swarm(Scene& scene, const RandomCase& c, const AddedPart& added, double tau)
{
    CaseRandom random(c.seed, added.part.key, 300);
    const double bend = random.between(0.2, 0.8), size = random.between(0.05, 0.3), distance = random.between(0, 4);
    for (const NodeId node : added.swarm) {
        const Vec3d from = random.inside_cube() * 2.0, by = from + random.inside_cube() * distance,
                    to = by + random.inside_cube() * distance;
        Trs trs;
        trs.translation = origin_of(c) +
                          (tau < bend ? glm::mix(from, by, tau / bend) : glm::mix(by, to, (tau - bend) / (1 - bend)));
        trs.scale = Vec3d(size);
        scene.set_transform(node, trs);
    }
}

void move_part(Scene& scene, const RandomCase& c, const AddedPart& added, double tau)
{
    CaseRandom random(c, added.part, PartFeature::Moving);
    const std::size_t kind = random.index(added.joint ? 6 : 7);  // vertices that follow joints are not written
    const Vec3d way = random.inside_cube();
    Trs trs;
    switch (kind) {
        case 0:
            trs.translation = way * tau;
            break;
        case 1:
            trs.rotation = glm::normalize(Vec4d(way * tau, 1));
            break;
        case 2:
            trs.scale = Vec3d(1 - 0.9 * tau) + Vec3d(0, 0.3 * tau, 0);
            break;
        case 3:
            trs.translation = way * (20 * tau);
            break;
        case 4:
            trs.scale = Vec3d(1, 1 - 2 * tau, 1);
            break;
        case 5:
            scene.set_visible(added.node, tau < 0.5);
            return;
        default:
            break;
    }
    if (kind != 6) return scene.set_transform(added.joint ? added.joint : added.node, added.place * trs.matrix());
    std::vector<Vec3f> bent;
    for (const Vec3f p : made_cage(added.part.cage).positions)
        bent.push_back(p + Vec3f(way * (0.5 * tau)) * (p.x * p.x + p.y));
    bent.resize(scene.cage(added.cage).cage.positions.size(), Vec3f(0.1f, 1.2f, 0.3f));  // a fin has one more vertex
    scene.write_vertices(added.cage, bent);
}

}  // namespace occam::test

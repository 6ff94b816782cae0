#include "tests/support/random_groups.h"

#include "tests/support/made_cages.h"

namespace occam::test {

Trs random_place(CaseRandom& random)
{
    Trs place;
    place.translation = random.inside_cube() * 2.0;
    const double w = random.between(0.1, 1);
    place.rotation = glm::normalize(Vec4d(random.inside_cube(), w));
    place.scale = Vec3d(random.between(0.4, 1.2));
    return place;
}

const char* RandomGroups::add(Scene& scene, CaseRandom& random, NodeId shown)
{
    NodeDesc group;
    group.place = random_place(random);
    const NodeId made = scene.add_node(scene.root(), group);
    for (std::size_t n = random.index(4); n > 0; --n) {
        NodeDesc member;
        // A group shows earlier groups only, so none shows itself.
        const bool is_nested = random.number() < 0.5 && !groups_.empty();
        member.instance_of = is_nested ? groups_[random.index(groups_.size())] : shown;
        member.place = random_place(random);
        member.visible = random.number() < 0.8;
        scene.add_node(made, member);
    }
    groups_.push_back(made);
    return "group";
}

const char* RandomGroups::add_crowd(Scene& scene, CaseRandom& random, NodeId shown)
{
    crowd_parent_ = scene.add_node(scene.root(), {});
    for (int k = 0; k < 300; ++k) {
        NodeDesc member;
        member.instance_of = shown;
        member.place = random_place(random);
        member.place.translation = random.inside_cube() * 4.0;
        member.place.scale *= 0.1;
        crowd_.push_back(scene.add_node(crowd_parent_, member));
    }
    return "crowd";
}

const char* RandomGroups::add_on_demand(Scene& scene, CaseRandom& random)
{
    const std::vector<MadeCage> all = made_cages();
    const Cage cage = all[random.index(all.size())].cage;
    OnDemandCage later;
    later.name = "on demand";
    later.bounds = cage.bounds();
    later.make = [cage] { return cage; };
    NodeDesc desc;
    desc.place = random_place(random);
    desc.cages = {scene.add(std::move(later))};
    demanded_.push_back(scene.add_node(scene.root(), desc));
    return "cage on demand";
}

const char* RandomGroups::edit_crowd(Scene& scene, CaseRandom& random, NodeId shown)
{
    const std::size_t which = random.index(crowd_.size());
    switch (random.index(5)) {
        case 0:
            for (std::size_t k = which; k < crowd_.size(); k += 3) scene.set_transform(crowd_[k], random_place(random));
            return "some of a crowd moved";
        case 1:
            scene.set_visible(crowd_[which], !scene.node(crowd_[which]).visible);
            return "one of a crowd visible";
        case 2:
            scene.remove(crowd_[which]);
            crowd_.erase(crowd_.begin() + static_cast<std::ptrdiff_t>(which));
            return "one of a crowd removed";
        case 3: {
            NodeDesc member;
            member.instance_of = shown;
            member.place = random_place(random);
            crowd_.push_back(scene.add_node(crowd_parent_, member));
            return "one of a crowd added";
        }
        default:
            scene.set_transform(crowd_parent_, random_place(random));
            return "crowd moved";
    }
}

const char* RandomGroups::edit(Scene& scene, CaseRandom& random, NodeId shown)
{
    switch (random.index(7)) {
        case 0:
            return add(scene, random, shown);
        case 1:
            if (demanded_.size() < 3) return add_on_demand(scene, random);
            scene.set_visible(demanded_.back(), !scene.node(demanded_.back()).visible);
            return "cage on demand visible";
        case 2:
            if (demanded_.empty()) return "nothing";
            scene.remove(scene.node(demanded_.back()).cages.at(0));
            scene.remove(demanded_.back());
            demanded_.pop_back();
            return "cage on demand removed";
        case 3:
        case 4:
            return crowd_.empty() ? add_crowd(scene, random, shown) : edit_crowd(scene, random, shown);
        case 5:
            if (groups_.empty()) return "nothing";
            scene.set_transform(groups_[random.index(groups_.size())], random_place(random));
            return "group moved";
        default:
            if (groups_.empty()) return "nothing";
            scene.remove(groups_.back());
            groups_.pop_back();
            return "group removed";
    }
}

}  // namespace occam::test

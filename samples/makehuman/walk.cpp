#include "walk.h"

#include <fstream>
#include <glm/gtc/quaternion.hpp>
#include <istream>

namespace sample {

using namespace occam;
using Quaternion = glm::dquat;

namespace {

// Holds a BVH file: the joints in the order of their channels, and for each frame the position of the first joint and the
// Euler angles of all joints.
struct Motion {
    struct Joint {
        std::string name;
        int parent = -1;
        Vec3d head{0};  ///< at rest
    };
    std::vector<Joint> joints;
    std::map<std::string, int> joint_of;
    /// Holds the rotation of each frame and joint relative to the whole figure's axes, with the joint's parents included.
    std::vector<std::vector<Quaternion>> turns;
    double frame_seconds = 0;
};

// Converts a point of the file, whose z axis is up and whose figure faces -y.
Vec3d upright(Vec3d p) { return {p.x, p.z, -p.y}; }
Quaternion upright(Quaternion q) { return {q.w, q.x, q.z, -q.y}; }

[[noreturn]] void refuse(const std::filesystem::path& file)
{
    throw Error(file.string(), "is not a motion file, or ends early");
}

// Reads the joints, up to the word MOTION.
void read_joints(std::istream& in, const std::filesystem::path& file, Motion& motion)
{
    std::vector<int> open;
    int at = -1;
    for (std::string word; in >> word && word != "MOTION";) {
        if (word == "ROOT" || word == "JOINT") {
            Motion::Joint joint;
            in >> joint.name;
            joint.parent = open.empty() ? -1 : open.back();
            at = static_cast<int>(motion.joints.size());
            motion.joint_of[joint.name] = at;
            motion.joints.push_back(joint);
        } else if (word == "End") {
            at = -1;
        } else if (word == "{") {
            open.push_back(at);
        } else if (word == "}") {
            if (open.empty()) refuse(file);
            open.pop_back();
        } else if (word == "OFFSET" && at >= 0) {
            Motion::Joint& joint = motion.joints[static_cast<std::size_t>(at)];
            Vec3d offset;
            in >> offset.x >> offset.y >> offset.z;
            joint.head = upright(offset) +
                         (joint.parent < 0 ? Vec3d(0) : motion.joints[static_cast<std::size_t>(joint.parent)].head);
        }
    }
}

Motion read_motion(const std::filesystem::path& file)
{
    std::ifstream in(file);
    if (!in) throw Error(file.string(), "cannot be read");
    Motion motion;
    read_joints(in, file, motion);
    std::size_t frames = 0;
    std::string word;
    in >> word >> frames >> word >> word >> motion.frame_seconds;
    // The file decides how many frames there are, whatever number it states.
    for (std::size_t f = 0; f < frames && in; ++f) {
        Vec3d unused, degrees;
        std::vector<Quaternion> turns;
        in >> unused.x >> unused.y >> unused.z;
        for (const Motion::Joint& joint : motion.joints) {
            in >> degrees.x >> degrees.y >> degrees.z;
            const Vec3d r = glm::radians(degrees);
            const Quaternion own = upright(glm::angleAxis(r.x, Vec3d(1, 0, 0)) * glm::angleAxis(r.y, Vec3d(0, 1, 0)) *
                                           glm::angleAxis(r.z, Vec3d(0, 0, 1)));
            turns.push_back(joint.parent < 0 ? own : turns[static_cast<std::size_t>(joint.parent)] * own);
        }
        motion.turns.push_back(std::move(turns));
    }
    if (!in || frames == 0 || !(motion.frame_seconds > 0)) refuse(file);
    return motion;
}

// Says which bone follows which joint, and the joint to which both point at rest: arms and legs rest in other poses there.
struct Pair {
    const char *bone, *joint;
    const char *next_bone = nullptr, *next_joint = nullptr;
};
constexpr Pair kPairs[] = {{"root", "Root"},
                           {"spine05", "Spine1"},
                           {"spine03", "Spine2"},
                           {"spine01", "Spine3"},
                           {"neck01", "Neck"},
                           {"head", "Head"},
                           {"pelvis.*", "Hips"},
                           {"foot.*", "Foot_*"},
                           {"clavicle.*", "Clavicle_*"},
                           {"upperarm01.*", "UpArm_*", "lowerarm01.*", "LoArm_*"},
                           {"lowerarm01.*", "LoArm_*", "wrist.*", "Hand_*"},
                           {"wrist.*", "Hand_*", "finger3-1.*", "Middle1_*"},
                           {"upperleg01.*", "UpLeg_*", "lowerleg01.*", "LoLeg_*"},
                           {"lowerleg01.*", "LoLeg_*", "foot.*", "Foot_*"}};

struct Follower {
    int joint = -1;                  ///< below 0: the bone follows the joint of the bone above
    Quaternion to_rest{1, 0, 0, 0};  ///< rotates from the body's rest pose to that of the motion
};

std::vector<Follower> followers(const Body& body, const Motion& motion)
{
    std::vector<Follower> all(body.bones.size());
    for (const Pair& pair : kPairs)
        for (const char side : {'L', 'R'}) {
            const auto named = [&](std::string name) {
                if (name.back() == '*') name.back() = side;
                return name;
            };
            const auto bone = [&](const char* name) { return static_cast<std::size_t>(body.bone_of.at(named(name))); };
            const auto joint = [&](const char* name) { return static_cast<std::size_t>(motion.joint_of.at(named(name))); };
            Follower& follower = all[bone(pair.bone)];
            follower.joint = static_cast<int>(joint(pair.joint));
            if (!pair.next_bone) continue;
            const Vec3d from = glm::normalize(body.bones[bone(pair.next_bone)].head - body.bones[bone(pair.bone)].head);
            const Vec3d to = glm::normalize(motion.joints[joint(pair.next_joint)].head -
                                            motion.joints[joint(pair.joint)].head);
            follower.to_rest = glm::normalize(Quaternion(1 + glm::dot(from, to), glm::cross(from, to)));
        }
    return all;
}

}  // namespace

Walk add_walk(Scene& scene, const Body& body, const std::filesystem::path& file)
{
    const Motion motion = read_motion(file);
    const std::vector<Follower> follow = followers(body, motion);
    const std::size_t frames = motion.turns.size();
    std::vector<Channel> channels(body.bones.size());
    for (std::size_t b = 0; b < body.bones.size(); ++b)
        channels[b] = {body.bones[b].node, Channel::Path::Rotation, Channel::Interpolation::Linear, {}, {}, 4};
    const auto foot = [&](char side) { return static_cast<std::size_t>(body.bone_of.at(std::string("foot.") + side)); };
    const std::size_t feet[2] = {foot('L'), foot('R')};

    Walk walk;
    walk.period = double(frames) * motion.frame_seconds;
    walk.floor = std::numeric_limits<double>::infinity();
    std::vector<Vec3d> before;
    for (std::size_t key = 0; key <= frames; ++key) {  // the last key is the first one again
        const auto& turns = motion.turns[key % frames];
        std::vector<Quaternion> whole(body.bones.size());
        std::vector<Vec3d> head(body.bones.size());
        for (std::size_t b = 0; b < body.bones.size(); ++b) {
            const int parent = body.bones[b].parent;
            const auto above = static_cast<std::size_t>(std::max(parent, 0));
            const Quaternion inherited = parent < 0 ? Quaternion(1, 0, 0, 0) : whole[above];
            whole[b] = follow[b].joint < 0 ? inherited
                                           : turns[static_cast<std::size_t>(follow[b].joint)] * follow[b].to_rest;
            head[b] = parent < 0 ? body.bones[b].head
                                 : head[above] + inherited * (body.bones[b].head - body.bones[above].head);
            const Quaternion own = glm::conjugate(inherited) * whole[b];
            channels[b].times.push_back(float(double(key) * motion.frame_seconds));
            for (const double value : {own.x, own.y, own.z, own.w}) channels[b].values.push_back(float(value));
        }
        // The lower foot stands still, so the body moves forward by as much as that foot moves back.
        const std::size_t lower = head[feet[0]].y < head[feet[1]].y ? feet[0] : feet[1];
        if (!before.empty()) walk.way += before[lower].z - head[lower].z;
        walk.floor = std::min(walk.floor, head[lower].y - (body.bones[lower].head.y - body.sole));
        before = head;
    }
    walk.clip = scene.add(Clip{"walk", std::move(channels)});
    return walk;
}

}  // namespace sample

// The game of this folder without its window; the tests play it too.
#pragma once

#include <occam/occam.h>

#include <cmath>
#include <filesystem>
#include <vector>

#include "worm.h"

namespace sample {

using namespace occam;

struct Character {
    NodeId node;
    ClipId clip;  ///< null: it stands still
};
struct Walker {
    NodeId node;
    ClipId clip;
    double radius, phase, speed;
};

/// The scene of a game: characters walk in circles, some appear and some vanish.
class Game {
public:
    /// Makes a game in which each file holds a character; without files the character is the worm.
    explicit Game(const std::vector<std::filesystem::path>& files = {})
    {
        for (const std::filesystem::path& file : files) {
            const AddedScene added = scene_.add(load(file), scene_.root());
            characters_.push_back({added.node, added.clips.empty() ? ClipId() : added.clips.front()});
        }
        if (files.empty()) {
            const sample::Worm worm = sample::add_worm(scene_, {0.9f, 0.35f, 0.25f});
            characters_.push_back({worm.node, worm.crawl});
        }
        size_ = std::max(1e-3, 2 * scene_.bounds().radius());
        height_ = -scene_.bounds().lo.y;
        for (const Character& character : characters_)
            scene_.set_visible(character.node, false);  // the originals are hidden; copies of them walk
        sample::add_surroundings(scene_, float(20 * size_));
        for (int i = 0; i < 12; ++i) appear();
    }

    /// Makes the edits of one frame, each of which costs no more than its path to the root.
    void step(double clock)
    {
        if (++frame_ % 20 == 0) appear();
        if (walkers_.size() > kMostWalkers) {
            scene_.remove(walkers_.front().node);  // the handle is dead from now on, and using it throws
            walkers_.erase(walkers_.begin());
        }
        for (const Walker& w : walkers_) {
            const double angle = w.phase + w.speed * clock;
            Trs place;
            place.translation = {w.radius * std::cos(angle), height_, -w.radius * std::sin(angle)};
            place.rotation = {0, std::sin((angle + 1.5708) / 2), 0, std::cos((angle + 1.5708) / 2)};
            scene_.set_transform(w.node, place);
            if (!w.clip) continue;
            // The pose is described, not evaluated: a character that is not seen is never skinned.
            const ClipAt now{w.clip, looped(time_range(scene_.clip(w.clip)), clock + w.phase)};
            scene_.pose({&now, 1}, w.node);
        }
    }

    Camera camera(double clock) const
    {
        const Vec3d eye = Vec3d(7 * std::cos(0.2 * clock), 3 + std::sin(0.5 * clock), 7 * std::sin(0.2 * clock)) * size_;
        return Camera::look_at(eye, {0, 0.5 * size_, 0}, {0, 1, 0}, 0.8f);
    }
    Scene& scene() { return scene_; }

private:
    void appear()
    {
        const double n = double(++made_);
        const Character& character = characters_[std::size_t(made_) % characters_.size()];
        walkers_.push_back({scene_.copy(character.node, scene_.root()), character.clip,
                            size_ * (1 + std::fmod(n * 0.618, 1.0) * 4), n * 2.4, 0.3 + 0.1 * std::fmod(n, 3)});
        scene_.set_visible(walkers_.back().node, true);
    }

    static constexpr std::size_t kMostWalkers = 16;

    Scene scene_;
    std::vector<Character> characters_;
    std::vector<Walker> walkers_;
    double size_ = 1, height_ = 0;
    int frame_ = 0, made_ = 0;
};

}  // namespace sample

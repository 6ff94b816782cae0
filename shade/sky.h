// Says whether a scene without an environment gets a sky.
#pragma once

namespace occam::shade {

enum class Sky : unsigned char {
    Auto,  ///< Scenes without a light, an environment or emitters that light them get it, with a key light.
    On,    ///< Every scene without an environment gets it, and the key light comes with it as for Auto.
    Off    ///< No scene gets it: without lights all is black.
};

}  // namespace occam::shade

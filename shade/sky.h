// Whether a scene without an environment gets a sky.
#pragma once

namespace occam::shade {

enum class Sky : unsigned char {
    Auto,  ///< if nothing in the scene shines: then with a key light over the camera's shoulder
    On,    ///< wherever the scene has no environment of its own
    Off    ///< never: without lights all is black
};

}  // namespace occam::shade

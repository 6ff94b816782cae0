// Adds a cage that a texture of another scene displaces, to a scene in which nothing is shaded (verify/).
#pragma once

#include "scenegraph/scene.h"

namespace occam {

/// Adds a cage as Scene::add() does, but does not ask whether the texture of its displacement belongs to the scene. Where
/// such a cage is diced, the store of textures must be that of the other scene.
CageId add_with_foreign_texture(Scene& scene, Cage cage);

}  // namespace occam

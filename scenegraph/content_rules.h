// The validation of what an application or an importer adds to the scene graph. All later code may rely on numbers that are
// finite and in range.
#pragma once

#include <span>
#include <string>

#include "scenegraph/animation.h"
#include "scenegraph/cage.h"
#include "scenegraph/camera.h"
#include "scenegraph/light.h"
#include "scenegraph/material.h"
#include "scenegraph/texture.h"

namespace occam {

/// Names an object in a message: its kind and, if it has one, its name, as in "cage 'fish'".
std::string naming(const char* kind, const std::string& name);

/// Returns an affine matrix with a last row of exactly 0, 0, 0, 1, which products and inverses may have rounded. Throws
/// Error if the matrix is not finite or not affine.
/// value        names the matrix in the message
/// kind, name   of the object that has it
Mat4d checked_affine(const Mat4d& m, const char* value, const char* kind, const std::string& name);

// Each function throws an Error that names the value and the rule it breaks. A choice has to be one of those that it has.
void check(const Material& material);
/// Checks the choices; sanitize() mends the rest.
void check(const Cage& cage);
/// Checks the role, and that the pixels, if there are any, are as many as the size says.
void check(const Texture& texture);
void check(const Light& light);
void check(const CameraLens& lens);
/// Checks the lens; that the camera's place and its keys are finite, with axes that have a length; and that there are no
/// keys, or from 2 to kMaxCameraKeys.
void check(const Camera& camera);
/// Checks that the moments are finite, not too far away, and in order.
void check(const Shutter& shutter);
/// Checks sizes, widths, increasing times, finite values, and that rotations have a length. The targets are not checked.
void check(const Clip& clip);
void check(const Trs& place, const std::string& name);
void check_morph_weights(std::span<const float> weights, const std::string& name);
void check(const Environment& environment);
/// Checks the angle of a perspective camera: from kNarrowestView to kWidestView.
void check_view_angle(float fov, const char* where);
/// Checks that the width over height of a picture is finite and above 0.
void check_aspect(float aspect, const char* where);

}  // namespace occam

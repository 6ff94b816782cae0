#include "lod/extent.h"
#include "occam/occam.h"

namespace occam {

Camera framing(Scene& scene, float aspect, ViewFrom from, Vec3d up)
{
    scene.refit();
    CameraFit fit(from, up, CameraLens().fov, aspect);
    lod::Extent().visit_points(scene, [&](Vec3d point) { fit.add(point); });
    return fit.camera();
}

}  // namespace occam

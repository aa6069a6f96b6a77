// Dots of the camera's own infra-red projector: they move with the camera, not with the world.
#pragma once

#include "tools/data/fault/camera_images.h"

namespace gw::fault {

// Draws about 2.4 dots per 1000 px, Gaussian of 1 px, brighter where the surface is near, at the
// places where rays of a projector 3 cm to the right of the left eye hit the surface. Its depth is
// that of the depth image where it has one, else 1.5 m. The places depend on the size of the image
// alone.
void DrawProjectorDots(const CameraOptics& optics, CameraImages* images);

}  // namespace gw::fault

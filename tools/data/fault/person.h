// A person before the camera.
#pragma once

#include "common/core/time.h"
#include "tools/data/fault/camera_images.h"

namespace gw::fault {

// Every 20 s a person walks into the view from the left (1.5 s), stays for 10 s, swaying a little,
// and walks out to the right (1.5 s). At a distance of 1 m, in textured clothes that move along,
// covering three quarters of the image while there. since_begin: of the fault.
void DrawPerson(const CameraOptics& optics, DurationUs since_begin, CameraImages* images);

}  // namespace gw::fault

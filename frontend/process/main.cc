// gw-frontend: a pose for every image.
#include "frontend/process/frontend_node.h"

int main(int argc, char** argv) {
  return gw::process::RunProgram(
      argc, argv,
      {"gw-frontend", "Tracking: CAMERA, DR and MAP_UPDATE in, FRAME_POSE and KEYFRAME out."}, {},
      gw::frontend::FrontendNode::Create);
}

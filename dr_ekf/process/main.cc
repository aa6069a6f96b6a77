// gw-dr-ekf: dead reckoning and the pose for control.
#include "dr_ekf/process/dr_node.h"

int main(int argc, char** argv) {
  return gw::process::RunProgram(
      argc, argv,
      {"gw-dr-ekf", "Dead reckoning: IMU and WHEEL in, DR and POSE (the pose for control) out."},
      {}, gw::dr_ekf::DrNode::Create);
}

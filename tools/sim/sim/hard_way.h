// What is hard on the way of a recorded robot, which comes without a building: where the light goes
// out and the walls are bare.
#pragma once

#include "tools/sim/sim/recorded_motion.h"
#include "tools/sim/sim/scenario.h"

namespace gw::sim {

// Adds to the scenario what its section `recorded` asks for, once in every part of the way: all
// lights off after a third of it, and bare walls, floor and ceiling from two thirds on; and ends it
// after the length that is asked for.
void MakeWayHard(const RecordedMotion& motion, Scenario* scenario);

}  // namespace gw::sim

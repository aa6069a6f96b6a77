// Where this project's own method departs from the published one, one name for each place, so that
// "the paper and one change" and "ours without one" can be run (docs/method.md, section 10).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace gw {

// Which method is the starting point: this project's, or section III of Du, Peng, Vela, "Good
// Weights", arXiv 2509.22910, as it is printed.
enum class Method { kOurs, kPaper };

// Documented in docs/method.md, section 10, under the name that kDepartures gives.
enum class Departure : uint8_t {
  kCorners,
  kTwoAlphas,
  kCloseLinks,
  kBound,
  kImageQuality,
  kReference,
  kFading,
  kReportedNoise,
  kFloor,
  kKnownNoise,
  kTrust,
  kLooksHealthy,
  kEdgeLoss,
  kPoseGraph,
  kWay,
  kScales,
  kRepeatedGlobalBa,
  kSettle,
  kDrift,
  kCalibration,
  kRecovery,
  kInlierGate,
  kLoopTest,
};

struct NamedDeparture {
  Departure departure;
  const char* name;  // lower case letters and underscores
};

inline constexpr std::array<NamedDeparture, 23> kDepartures = {{
    {Departure::kCorners, "corners"},
    {Departure::kTwoAlphas, "two_alphas"},
    {Departure::kCloseLinks, "close_links"},
    {Departure::kBound, "bound"},
    {Departure::kImageQuality, "image_quality"},
    {Departure::kReference, "reference"},
    {Departure::kFading, "fading"},
    {Departure::kReportedNoise, "reported_noise"},
    {Departure::kFloor, "floor"},
    {Departure::kKnownNoise, "known_noise"},
    {Departure::kTrust, "trust"},
    {Departure::kLooksHealthy, "looks_healthy"},
    {Departure::kEdgeLoss, "edge_loss"},
    {Departure::kPoseGraph, "pose_graph"},
    {Departure::kWay, "way"},
    {Departure::kScales, "scales"},
    {Departure::kRepeatedGlobalBa, "repeated_gba"},
    {Departure::kSettle, "settle"},
    {Departure::kDrift, "drift"},
    {Departure::kCalibration, "calibration"},
    {Departure::kRecovery, "recovery"},
    {Departure::kInlierGate, "inlier_gate"},
    {Departure::kLoopTest, "loop_test"},
}};

class DepartureSet {
 public:
  bool Contains(Departure d) const { return (bits_ >> static_cast<unsigned>(d) & 1U) != 0; }
  void Insert(Departure d) { bits_ |= 1U << static_cast<unsigned>(d); }

 private:
  uint32_t bits_ = 0;
};

}  // namespace gw

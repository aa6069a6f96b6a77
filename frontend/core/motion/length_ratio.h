// How long vision takes the ways to be that dead reckoning (DR) tells, over all windows so far. The
// lengths of vision are corrected by it when they are found to be wrong, early and therefore
// coarsely, and again whenever four times as much has been driven: half the error.
//
// A baseline or a unit is as wrong in the first image as in the newest: a factor that not all
// windows tell is another fault, of wheels that have changed on the way.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "frontend/core/motion/dr_disagreement.h"

namespace gw::frontend {

class LengthRatio {
 public:
  // A window, in one frame.
  struct Window {
    Eigen::Vector2d by_dr, by_vision;  // m, vision's in its lengths of now
    double variance = 0;               // m^2, of what is left between the two, per axis
    double gained_m_s = 0;             // speed at its end less that at its begin
  };
  // Windows in which wheels that are late would make up for a fault of lengths do not count.
  void Add(const Window& window);

  // The factor by which vision's ways are longer, as they all are and in the same direction; empty:
  // there is none that is worth a word (FaultOf) or that all windows tell, or too little way.
  std::optional<double> Fault() const;

  // Vision / DR, by least squares; 1 when empty.
  double value() const { return square_ > 0 ? product_.x() / square_ : 1; }

  // The lengths of vision are `factor` times shorter from now on, and so are those of before.
  void Corrected(double factor);
  bool IsBetterNow() const;

 private:
  bool AllTellIt() const;

  Eigen::Vector2d product_ = Eigen::Vector2d::Zero();  // m^2, along DR's way and to its left
  double square_ = 0;                                  // m^2, of DR's ways
  double square_of_vision_ = 0;                        // m^2
  double noise_ = 0;                                   // m^2, expected of the squares left
  double corrected_at_ = 0;                            // square_ of then; 0: never
};

}  // namespace gw::frontend

// How late the wheels' stamps are against those of the gyro.
//
// Both tell the same turns. Shifted by the right time, the wheels' turn over each of their
// intervals is the gyro's over the shifted interval, times a factor (track, scale) and plus a rate
// (bias), which a regression finds for every shift of a grid. The shift with the smallest residual
// is the offset. Its variance is that of the residuals where they tell of it, in turns that begin
// or end (White, A heteroskedasticity-consistent covariance matrix estimator, Econometrica 1980): a
// base that drives straight has small residuals, and they say nothing. What resampling, queues and
// a wrong calibration.wheel.time_offset_s do on the average is in it. See
// docs/adr/0025-time-offset.md.
#pragma once

#include <array>
#include <deque>

#include "common/core/time.h"

namespace gw::dr_ekf {

class TimeOffset {
 public:
  // rate: rad/s about z of B, as measured; times grow.
  void AddGyro(Utime utime, double rate);
  // The wheels' turn (rad) over (begin, end] of their stamps.
  void AddWheels(Utime begin, Utime end, double turn);
  // Time began anew.
  void Forget();

  // s; positive: the wheels' stamps are late. Zero as long as no turn has told anything.
  double offset_s() const { return offset_s_; }
  double sigma_s() const { return sigma_s_; }

  // What an offset may be before anything is known: a tenth of a second, as serial bases and queues
  // have it.
  static constexpr double kPrior = 0.1;  // s
  static constexpr int kSteps = 30;      // of the grid, to either side
  static constexpr double kStep = 0.01;  // s; a turn begins and ends within some tenths of a second

 private:
  struct Wheels {
    Utime begin, end;
    double turn;
  };
  using Turns = std::array<double, 2 * kSteps + 1>;  // of the gyro, at each shift
  struct Sums {  // of products of gyro turn g, time d, wheel turn w, at one shift
    double gg = 0, gd = 0, gw = 0;
  };

  // Gyro's turn since its first sample; false: not covered.
  bool TurnAt(Utime utime, double* turn) const;
  bool Use(const Wheels& wheels);
  double ResidualAt(int step) const;
  void Estimate();
  void Weigh(const Turns& turns, const Wheels& wheels);

  struct Stamped {
    Utime utime;
    double turn;
  };
  std::deque<Stamped> gyro_;
  double last_rate_ = 0;
  std::deque<Wheels> waiting_;  // for the gyro to cover their latest shift
  std::array<Sums, 2 * kSteps + 1> sums_;
  double dd_ = 0, dw_ = 0, ww_ = 0;
  // The regression at the best shift, and sums of squares j^2 and (j e)^2 of slopes j (rad/s, of
  // the turn with the shift) and residuals e there.
  int best_ = 0;
  double factor_ = 0, rate_ = 0;
  double slopes_ = 0, spread_ = 0;
  double offset_s_ = 0, sigma_s_ = kPrior;
};

}  // namespace gw::dr_ekf

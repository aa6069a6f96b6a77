// Allan variance of a sensor at rest, and the noise that explains it (IEEE Std 952-1997, annex C).
#pragma once

#include <span>
#include <vector>

namespace gw::calibrate {

struct AllanPoint {
  double tau_s = 0;     // averaging time
  double variance = 0;  // of the sensor's unit, squared
  double relative = 0;  // standard deviation of `variance`, as a share of it
};

// Overlapping Allan variance of a rate that is sampled every dt_s, at averaging times that double
// from dt_s to a ninth of the whole. The relative error is sqrt(2 / (T/tau - 1)), twice that of
// equation C.20, which is of the deviation.
std::vector<AllanPoint> AllanVariance(std::span<const double> rate, double dt_s);

struct NoiseTerm {
  double value = 0;
  double sigma = 0;  // one standard deviation
  // A recording that is too short, or in which another noise is stronger, does not tell it; then
  // the true value is below value + 2 sigma.
  bool determined() const { return value > 2 * sigma; }
};

struct NoiseModel {
  NoiseTerm density;      // white noise N: variance N^2/tau; unit/sqrt(Hz)
  NoiseTerm instability;  // flicker noise B of the bias: variance B^2 2 ln2/pi; unit
  NoiseTerm walk;         // random walk K of the bias: variance K^2 tau/3; unit/s/sqrt(Hz)
};

// Least squares of the three and of quantisation (3 Q^2/tau^2) over the points, each weighted by
// its error, none of the four negative. Precondition: at least 5 points.
NoiseModel FitNoise(const std::vector<AllanPoint>& points);

}  // namespace gw::calibrate

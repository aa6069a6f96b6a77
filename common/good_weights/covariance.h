// What a motion by dead reckoning (DR) is worth before and after alpha: nominal, reported and
// scaled covariances (docs/method.md, sections 3.3 and 3.5). One definition for the prior of an
// image, the edges of local and global bundle adjustment and of the pose graph.
//
// Covariances are those of a right perturbation [translation; rotation] of the motion; m^2, rad^2.
#pragma once

#include "common/config/dr_weight_config.h"
#include "common/core/se3.h"
#include "common/core/time.h"
#include "common/good_weights/alpha.h"

namespace gw {

// Sigma_d0 of an interval: diag(sigma_t^2, sigma_r^2) of the configuration for each 1/30 s of it,
// the period of the frames of Du, Peng, Vela, "Good Weights", arXiv 2509.22910, section III-B.
// interval > 0.
Matrix6d NominalCovariance(DurationUs interval, const DrWeightConfig& config);

// Sigma_d of an edge between keyframes, body axes: the larger of nominal and reported covariance,
// in every direction; the nominal one by the paper's law. The errors of way and heading of edges
// that follow each other are one bias, which edges that are independent of each other would take
// for knowledge: the nominal noise keeps them from that (docs/adr/0020-two-witnesses.md). Height,
// roll and pitch are held by floor and gravity, their errors do not add up: they have the reported
// noise alone (docs/adr/0065-what-the-floor-holds.md). reported: positive semi-definite; zero:
// nothing is reported.
Matrix6d DrCovariance(DurationUs interval, const Matrix6d& reported, const DrWeightConfig& config);

// Covariance of a motion that counts with the scale alpha > 0: Sigma_d / alpha, per block. It is
// not below `honest`: blind vision is no reason to believe dead reckoning more than it does itself
// (docs/adr/0012-no-more-than-dr-knows.md). honest: zero where the scale stands as it is.
Matrix6d ScaledCovariance(const Matrix6d& cov, const DrScale& alpha, const Matrix6d& honest);

// The scale with which `cov` counts once it has become `scaled`, per block of three:
// 3 / tr(inv(cov) scaled). It is alpha where the bound does not act, and less where it does. Both
// positive definite.
DrScale EffectiveScale(const Matrix6d& cov, const Matrix6d& scaled);

}  // namespace gw

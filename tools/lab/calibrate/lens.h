// Projection of the two lens models that gw-calibrate camera knows, for numbers of any kind.
#pragma once

#include <ceres/ceres.h>

#include <array>
#include <string>

namespace gw::calibrate {

enum class LensModel {
  kRadtan,       // pinhole with k1 k2 p1 p2 k3 (Brown-Conrady, OpenCV's order)
  kEquidistant,  // theta (1 + k1 theta^2 + ... + k4 theta^8) (Kannala, Brandt, 2006)
};

inline constexpr int kMaxLensParameters = 9;
inline constexpr int NumLensParameters(LensModel model) {
  return model == LensModel::kRadtan ? 9 : 8;
}

// Names of the parameters, in their order.
inline constexpr std::array<const char*, kMaxLensParameters> LensParameterNames(LensModel model) {
  if (model == LensModel::kRadtan) {
    return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  }
  return {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", ""};
}

// Pixel of a point in the camera's frame (x right, y down, z forward). False where the model does
// not see it: behind a pinhole.
template <typename T>
bool ProjectThroughLens(LensModel model, const T* lens, const T* point, T* pixel) {
  using ceres::atan2;
  using ceres::sqrt;
  if (model == LensModel::kRadtan) {
    if (point[2] < T(1e-6)) return false;
    const T x = point[0] / point[2], y = point[1] / point[2];
    const T r2 = x * x + y * y;
    const T radial = T(1) + r2 * (lens[4] + r2 * (lens[5] + r2 * lens[8]));
    const T& p1 = lens[6];
    const T& p2 = lens[7];
    pixel[0] = lens[0] * (x * radial + T(2) * p1 * x * y + p2 * (r2 + T(2) * x * x)) + lens[2];
    pixel[1] = lens[1] * (y * radial + p1 * (r2 + T(2) * y * y) + T(2) * p2 * x * y) + lens[3];
    return true;
  }
  const T r2 = point[0] * point[0] + point[1] * point[1];
  T scale = T(1) / point[2];
  if (r2 > T(1e-18)) {
    const T r = sqrt(r2);
    const T theta = atan2(r, point[2]);
    const T t2 = theta * theta;
    scale = theta * (T(1) + t2 * (lens[4] + t2 * (lens[5] + t2 * (lens[6] + t2 * lens[7])))) / r;
  } else if (point[2] < T(1e-9)) {
    return false;
  }
  pixel[0] = lens[0] * scale * point[0] + lens[2];
  pixel[1] = lens[1] * scale * point[1] + lens[3];
  return true;
}

}  // namespace gw::calibrate

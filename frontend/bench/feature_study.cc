// Quality of the features on a recording in TUM RGB-D format, beside cv::ORB on the same images:
//
//   feature_study SEQUENCE_DIR [step]
//
// Frames k and k + gap are matched by mutual nearest descriptors alone (no prediction). What is
// right, and how precisely features are located, is judged by a relative pose from SIFT features:
// the motion capture of a hand-held recording is itself only good to several pixels. Pairs where
// SIFT finds too little are left out.
//
// depth: share of features with depth. right: matches within 2 px + 3 * scale of the reference.
// fit: those within 3 * scale of the pose that fits them best; sigma: robust, of their residuals
// about that pose. repeat: share of the features of k seen by k + gap that are found again
// within 1.5 * scale. pose: median difference of the fitted pose from the reference.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/core/median.h"
#include "frontend/core/features/depth_lookup.h"
#include "frontend/core/features/descriptor_sampler.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/image_pyramid.h"
#include "frontend/core/features/image_undistorter.h"
#include "frontend/core/features/tum_geometry.h"

namespace gw::frontend {
namespace {

struct Entry {
  double t;
  std::string file;
};

std::vector<Entry> ReadList(const std::string& path) {
  std::vector<Entry> out;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    Entry e;
    if (fields >> e.t >> e.file) out.push_back(e);
  }
  return out;
}

std::map<double, SE3> ReadPoses(const std::string& path) {
  std::map<double, SE3> out;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream f(line);
    double t, x, y, z, qx, qy, qz, qw;
    if (f >> t >> x >> y >> z >> qx >> qy >> qz >> qw) {
      out.emplace(t, SE3(Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z}));
    }
  }
  return out;
}

struct Frame {
  cv::Mat gray, depth;
  SE3 T_GC;
};

CameraFrame Message(const Frame& f) {
  CameraFrame m;
  m.left = {f.gray.data, f.gray.cols, f.gray.rows, static_cast<int>(f.gray.step),
            PixelFormat::kGray8};
  m.depth = {f.depth.data, f.depth.cols, f.depth.rows, static_cast<int>(f.depth.step),
             PixelFormat::kDepth16};
  return m;
}

constexpr int kMinReferenceMatches = 60;

using Extract = std::function<void(const Frame&, FeatureFrame*)>;

struct Match {
  int a, b;
};

std::vector<Match> MutualMatches(const FeatureFrame& a, const FeatureFrame& b) {
  const auto nearest = [](const FeatureFrame& from, const FeatureFrame& to) {
    std::vector<int> best(from.features.size(), -1);
    for (size_t i = 0; i < from.features.size(); ++i) {
      int d1 = 65, d2 = 257;
      for (size_t j = 0; j < to.features.size(); ++j) {
        const int d = HammingDistance(from.descriptors[i], to.descriptors[j]);
        if (d < d1) {
          d2 = d1;
          d1 = d;
          best[i] = static_cast<int>(j);
        } else if (d < d2) {
          d2 = d;
        }
      }
      if (d1 > 0.85 * d2) best[i] = -1;
    }
    return best;
  };
  const std::vector<int> ab = nearest(a, b), ba = nearest(b, a);
  std::vector<Match> out;
  for (size_t i = 0; i < ab.size(); ++i) {
    if (ab[i] >= 0 && ba[static_cast<size_t>(ab[i])] == static_cast<int>(i)) {
      out.push_back({static_cast<int>(i), ab[i]});
    }
  }
  return out;
}

double Median(std::vector<double> v) {
  return v.empty() ? 0 : MedianOf(&v);
}

// Standard deviation of a normal distribution with the same median absolute value.
double RobustSigma(std::vector<double> v) {
  for (double& x : v) x = std::abs(x);
  return kSigmaOverMedian * Median(v);
}

struct Stats {
  int pairs = 0;
  double features = 0, with_depth = 0, matches = 0, right = 0, fit = 0;
  double same = 0, visible = 0;
  std::map<int, std::vector<double>> residuals;  // per level, px / scale
  std::vector<double> all, px, depth, trans, rot;
};

struct Obs {
  Eigen::Vector3d p_A;
  Eigen::Vector2d uv;
  double scale;
  int level;
  double depth;
};

// Robust (Geman-McClure) least squares from T_BA.
SE3 FitPose(const std::vector<Obs>& right, const SE3& T_BA, const RectifiedCamera& camera) {
  SE3 T = T_BA;
  for (int it = 0; it < 15; ++it) {
    Matrix6d H = Matrix6d::Identity() * 1e-9;
    Vector6d g = Vector6d::Zero();
    for (const Obs& o : right) {
      const Eigen::Vector3d p = T * o.p_A;
      if (p.z() <= 0.1) continue;
      const Eigen::Vector2d r = (camera.Project(p) - o.uv) / o.scale;
      const double c2 = 2.0 * 2.0;
      const double w = 1.0 / std::pow(1 + r.squaredNorm() / c2, 2);
      Eigen::Matrix<double, 2, 3> Jp;
      const double iz = 1 / p.z();
      Jp << camera.fx * iz, 0, -camera.fx * p.x() * iz * iz, 0, camera.fy * iz,
          -camera.fy * p.y() * iz * iz;
      Eigen::Matrix<double, 3, 6> Jx;
      const Eigen::Matrix3d R = T.rotation().toRotationMatrix();
      Jx << R, -R * Skew(o.p_A);
      const Eigen::Matrix<double, 2, 6> J = Jp * Jx / o.scale;
      H += w * J.transpose() * J;
      g += w * J.transpose() * r;
    }
    T = T * SE3::Exp(-H.ldlt().solve(g));
  }
  return T;
}

void Accumulate(const FeatureFrame& a, const FeatureFrame& b, const SE3& T_BA_truth,
                const RectifiedCamera& camera, Stats* s) {
  ++s->pairs;
  s->features += static_cast<double>(a.features.size());
  for (const Feature& f : a.features) s->with_depth += f.has_depth();
  const std::vector<Match> matches = MutualMatches(a, b);
  std::vector<Obs> right;
  for (const Match& m : matches) {
    const Feature& fa = a.features[static_cast<size_t>(m.a)];
    const Feature& fb = b.features[static_cast<size_t>(m.b)];
    if (!fa.has_depth()) continue;
    s->matches += 1;
    const Eigen::Vector3d p_A = camera.Unproject(fa.u, fa.v, fa.depth);
    const Eigen::Vector3d p_B = T_BA_truth * p_A;
    if (p_B.z() <= 0.1) continue;
    const double scale = std::pow(1.2, fb.level);
    const Eigen::Vector2d uv(fb.u, fb.v);
    if ((camera.Project(p_B) - uv).norm() > 2 + 3 * scale) continue;
    s->right += 1;
    right.push_back({p_A, uv, scale, fb.level, fb.depth});
  }
  if (right.size() < 12) return;
  const SE3 T = FitPose(right, T_BA_truth, camera);
  const SE3 error = T_BA_truth.inverse() * T;
  s->trans.push_back(error.translation().norm());
  s->rot.push_back(LogSO3(error.rotation()).norm());
  for (const Obs& o : right) {
    const Eigen::Vector3d p = T * o.p_A;
    const Eigen::Vector2d r = camera.Project(p) - o.uv;
    if (r.norm() / o.scale < 3) s->fit += 1;
    for (const double e : {r.x(), r.y()}) {
      s->residuals[o.level].push_back(e / o.scale);
      s->all.push_back(e / o.scale);
      s->px.push_back(e);
    }
    if (o.depth > 0) s->depth.push_back(camera.bf() / p.z() - camera.bf() / o.depth);
  }
  // Repeatability: features of A that project into B's image and have one within 2.5 px * scale.
  for (const Feature& f : a.features) {
    if (!f.has_depth()) continue;
    const Eigen::Vector3d p = T * camera.Unproject(f.u, f.v, f.depth);
    if (p.z() < 0.1) continue;
    const Eigen::Vector2d uv = camera.Project(p);
    if (uv.x() < 40 || uv.y() < 40 || uv.x() > 600 || uv.y() > 440) continue;
    s->visible += 1;
    for (const Feature& h : b.features) {
      if (std::abs(h.level - f.level) <= 1 &&
          (Eigen::Vector2d(h.u, h.v) - uv).norm() < 1.5 * std::pow(1.2, f.level)) {
        s->same += 1;
        break;
      }
    }
  }
}

void Print(const char* name, size_t gap, const Stats& s) {
  const double n = s.pairs;
  std::printf(
      "%-6s gap %2zu: N %5.1f depth %4.1f%% | matches %5.1f right %5.1f (%4.1f%%) fit %5.1f | "
      "repeat "
      "%4.1f%% | sigma %.3f /scale, %.3f px, disparity %.3f px | pose %.2f mm %.3f deg\n",
      name, gap, s.features / n, 100 * s.with_depth / s.features, s.matches / n, s.right / n,
      100 * s.right / s.matches, s.fit / n, 100 * s.same / s.visible, RobustSigma(s.all),
      RobustSigma(s.px), RobustSigma(s.depth), 1e3 * Median(s.trans), 57.2958 * Median(s.rot));
  std::printf("       sigma by level:");
  for (const auto& [level, r] : s.residuals) std::printf(" %d:%.2f", level, RobustSigma(r));
  std::printf("\n");
}

struct SiftFrame {
  std::vector<Feature> features;
  cv::Mat descriptors;
};

SiftFrame ExtractSift(const Frame& f, const ImageUndistorter& undistorter,
                      const DepthLookup& lookup) {
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(3000, 3, 0.02);
  std::vector<cv::KeyPoint> keypoints;
  SiftFrame out;
  sift->detectAndCompute(f.gray, cv::noArray(), keypoints, out.descriptors);
  for (const cv::KeyPoint& k : keypoints) {
    Feature g;
    const auto uv = undistorter.Undistort(k.pt.x, k.pt.y);
    g.u = uv ? uv->x() : k.pt.x;
    g.v = uv ? uv->y() : k.pt.y;
    g.depth = lookup.At(Message(f).depth, k.pt.x, k.pt.y);
    out.features.push_back(g);
  }
  return out;
}

// Relative pose T_BA of two frames from SIFT features, an independent and more precise judge than
// the motion capture.
SE3 ReferencePose(const Frame& fa, const Frame& fb, const RectifiedCamera& camera,
                  const ImageUndistorter& undistorter, const DepthLookup& lookup, int* n) {
  const SiftFrame a = ExtractSift(fa, undistorter, lookup),
                  b = ExtractSift(fb, undistorter, lookup);
  std::vector<std::vector<cv::DMatch>> matches;
  cv::BFMatcher(cv::NORM_L2).knnMatch(a.descriptors, b.descriptors, matches, 2);
  SE3 T = fb.T_GC.inverse() * fa.T_GC;
  for (const double gate : {25.0, 8.0, 4.0}) {
    std::vector<Obs> obs;
    for (const auto& m : matches) {
      if (m.size() < 2 || m[0].distance > 0.85f * m[1].distance) continue;
      const Feature& p = a.features[static_cast<size_t>(m[0].queryIdx)];
      const Feature& q = b.features[static_cast<size_t>(m[0].trainIdx)];
      if (!p.has_depth()) continue;
      const Eigen::Vector3d p_A = camera.Unproject(p.u, p.v, p.depth);
      const Eigen::Vector3d p_B = T * p_A;
      if (p_B.z() < 0.1 || (camera.Project(p_B) - Eigen::Vector2d(q.u, q.v)).norm() > gate)
        continue;
      obs.push_back({p_A, {q.u, q.v}, 1, 0, 0});
    }
    T = FitPose(obs, T, camera);
    *n = static_cast<int>(obs.size());
  }
  return T;
}

int Main(int argc, char** argv) {
  if (argc < 2) return 2;
  cv::setNumThreads(1);
  const std::string dir = argv[1];
  const size_t step = argc > 2 ? std::stoul(argv[2]) : 6;
  const std::vector<Entry> gray = ReadList(dir + "/rgb.txt"), depth = ReadList(dir + "/depth.txt");
  const std::map<double, SE3> poses = ReadPoses(dir + "/groundtruth.txt");
  std::vector<Frame> frames;
  for (const Entry& g : gray) {
    const auto d = std::min_element(
        depth.begin(), depth.end(),
        [&](const Entry& x, const Entry& y) { return std::abs(x.t - g.t) < std::abs(y.t - g.t); });
    const auto after = poses.lower_bound(g.t);
    if (after == poses.begin() || after == poses.end() || std::abs(d->t - g.t) > 0.02) continue;
    const auto before = std::prev(after);
    Frame f;
    f.T_GC = Interpolate(before->second, after->second,
                         (g.t - before->first) / (after->first - before->first));
    f.gray = cv::imread(dir + "/" + g.file, cv::IMREAD_GRAYSCALE);
    f.depth = cv::imread(dir + "/" + d->file, cv::IMREAD_UNCHANGED);
    frames.push_back(f);
  }
  const CameraGeometry geometry = TumGeometry();
  FeatureExtractor ours = FeatureExtractor::Create({}, geometry).value();
  const ImageUndistorter undistorter(geometry);
  const DepthLookup lookup(geometry);
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(800, 1.2f, 8);
  const std::vector<std::pair<const char*, Extract>> extractors = {
      {"ours", [&](const Frame& f, FeatureFrame* out) { ours.Extract(Message(f), out); }},
      {"cv", [&](const Frame& f, FeatureFrame* out) {
         std::vector<cv::KeyPoint> keypoints;
         cv::Mat descriptors;
         orb->detectAndCompute(f.gray, cv::noArray(), keypoints, descriptors);
         *out = {};
         for (size_t i = 0; i < keypoints.size(); ++i) {
           const cv::KeyPoint& k = keypoints[i];
           const auto uv = undistorter.Undistort(k.pt.x, k.pt.y);
           if (!uv) continue;
           Feature g;
           g.u = uv->x();
           g.v = uv->y();
           g.level = static_cast<uint8_t>(k.octave);
           g.depth = lookup.At(Message(f).depth, k.pt.x, k.pt.y);
           Descriptor d;
           std::memcpy(d.data(), descriptors.ptr(static_cast<int>(i)), 32);
           out->features.push_back(g);
           out->descriptors.push_back(d);
         }
       }}};
  // Relative poses of the pairs that are used.
  std::map<std::pair<size_t, size_t>, SE3> reference;
  for (const size_t gap : {5u, 15u}) {
    for (size_t k = 0; k + gap < frames.size(); k += step) {
      int num_matches = 0;
      const SE3 T_BA = ReferencePose(frames[k], frames[k + gap], geometry.rectified, undistorter,
                                     lookup, &num_matches);
      if (num_matches > kMinReferenceMatches) reference[{k, k + gap}] = T_BA;
    }
  }
  for (const auto& [name, extract] : extractors) {
    for (const size_t gap : {5u, 15u}) {
      Stats stats;
      for (const auto& [pair, T_BA] : reference) {
        if (pair.second - pair.first != gap) continue;
        FeatureFrame a, b;
        extract(frames[pair.first], &a);
        extract(frames[pair.second], &b);
        Accumulate(a, b, T_BA, geometry.rectified, &stats);
      }
      Print(name, gap, stats);
    }
  }
  return 0;
}

}  // namespace
}  // namespace gw::frontend

int main(int argc, char** argv) {
  return gw::frontend::Main(argc, argv);
}

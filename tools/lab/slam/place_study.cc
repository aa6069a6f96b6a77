// Place recognition measured: our index beside a vocabulary tree, on the same features.
//
//   place_study photos DIR                    DIR/1.jpg ... and DIR/loop_ground_truth.bmp
//   place_study log LOG.lcm ROBOT.yaml        a log with GROUND_TRUTH; one image a second
//
// Images come in order; each is a query to those before it (photos: all but the last 5; log: all
// but the last 20 s), then is filed. An answer is the best-scored image. Same place: as the ground
// truth of the photographs says; in a log, within 1 m and 30 deg. Printed: the largest recall
// (queries that have a true answer and got one) over all score thresholds that accept no wrong
// answer, and times. The tree is trained on the images of the first argument after `--train`
// (a log and its YAML), otherwise on the images themselves, which flatters it.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "backend/core/place/place_index.h"
#include "common/camera/camera_model.h"
#include "common/config/loader.h"
#include "common/core/random.h"
#include "common/process/event_log.h"
#include "common/wire/channels.h"
#include "common/wire/wire.h"
#include "frontend/core/features/feature_frame.h"
#include "frontend/core/features/orb_extractor.h"

namespace gw::tools {
namespace {

using Descriptors = std::vector<Descriptor>;

struct Study {
  std::vector<Descriptors> images;
  std::vector<std::vector<bool>> same_place;  // [i][j], j < i
  size_t recent = 5;                          // images before i that are no answers
};

double Seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Study ReadPhotos(const std::string& folder) {
  Study out;
  for (int i = 1;; ++i) {
    const cv::Mat image =
        cv::imread(folder + "/" + std::to_string(i) + ".jpg", cv::IMREAD_GRAYSCALE);
    if (image.empty()) break;
    OrbConfig config;
    auto extractor = frontend::OrbExtractor::Create(config, image.cols, image.rows);
    std::vector<frontend::OrbKeypoint> keypoints;
    Descriptors descriptors;
    extractor->Extract(
        {image.data, image.cols, image.rows, static_cast<int>(image.step), PixelFormat::kGray8},
        nullptr, &keypoints, &descriptors);
    out.images.push_back(descriptors);
  }
  const cv::Mat truth = cv::imread(folder + "/loop_ground_truth.bmp", cv::IMREAD_GRAYSCALE);
  const int n = static_cast<int>(out.images.size());
  if (truth.rows != n || truth.cols != n) return {};
  for (int i = 0; i < n; ++i) {
    out.same_place.emplace_back();
    for (int j = 0; j < i; ++j) {
      out.same_place[i].push_back(truth.at<uchar>(i, j) > 127 || truth.at<uchar>(j, i) > 127);
    }
  }
  return out;
}

Study ReadLog(const std::string& path, const std::string& robot) {
  Study out;
  const auto config = LoadRobotConfig(robot);
  auto log = process::EventLogReader::Open(path);
  if (!config || !log) return out;
  const auto geometry = MakeCameraGeometry(config->calibration);
  auto extractor = frontend::FeatureExtractor::Create(config->frontend.orb, *geometry);
  std::map<int64_t, SE3> truth;
  std::vector<int64_t> times;
  int64_t next = 0;
  while (const auto event = log->Next()) {
    if (event->channel == wire::kGroundTruth) {
      const auto pose = wire::Decode<GroundTruth>(event->data);
      if (pose) truth[pose->utime.us] = pose->T_GB;
    } else if (event->channel == wire::kCamera) {
      const auto camera = wire::DecodeCamera({event->data.begin(), event->data.end()});
      if (!camera || camera->frame.utime.us < next) continue;
      next = camera->frame.utime.us + 1000000;
      frontend::FeatureFrame features;
      extractor->Extract(camera->frame, &features);
      out.images.push_back(features.descriptors);
      times.push_back(camera->frame.utime.us);
    }
  }
  out.recent = 20;
  for (size_t i = 0; i < times.size(); ++i) {
    out.same_place.emplace_back();
    for (size_t j = 0; j < i; ++j) {
      const auto a = truth.lower_bound(times[i]);
      const auto b = truth.lower_bound(times[j]);
      if (a == truth.end() || b == truth.end()) {
        out.same_place[i].push_back(false);
        continue;
      }
      const SE3 T_ab = a->second.inverse() * b->second;
      out.same_place[i].push_back(T_ab.translation().norm() < 1.0 &&
                                  LogSO3(T_ab.rotation()).norm() < 0.52);
    }
  }
  return out;
}

struct Answer {
  double score = 0;
  bool right = false;
};

void Report(const char* name, const Study& study, const std::vector<Answer>& answers,
            double insert_s, double query_s) {
  int possible = 0;
  for (size_t i = 0; i < study.images.size(); ++i) {
    for (size_t j = 0; j + study.recent < i; ++j) {
      if (!study.same_place[i][j]) continue;
      ++possible;
      break;
    }
  }
  double worst = 0;
  int best_right = 0;
  for (const Answer& a : answers) {
    if (!a.right) worst = std::max(worst, a.score);
    best_right += a.right;
  }
  int found = 0;
  for (const Answer& a : answers) found += a.right && a.score > worst;
  const double n = static_cast<double>(study.images.size());
  std::printf(
      "%-6s recall at 100 %% precision %5.1f %% (%d of %d), best answer right %5.1f %%, threshold "
      "%.4f, insert %.2f ms, query %.2f ms\n",
      name, 100.0 * found / std::max(possible, 1), found, possible,
      100.0 * best_right / std::max(possible, 1), worst, 1e3 * insert_s / n, 1e3 * query_s / n);
}

void RunIndex(const Study& study) {
  backend::PlaceIndex index;
  std::vector<Answer> answers;
  double insert_s = 0, query_s = 0;
  size_t filed = 0;
  for (size_t i = 0; i < study.images.size(); ++i) {
    const double t0 = Seconds();
    while (filed + study.recent < i) {
      index.Insert(backend::Place{{static_cast<int64_t>(filed) + 1}, study.images[filed]});
      ++filed;
    }
    const double t1 = Seconds();
    const auto found = index.Query(study.images[i]);
    query_s += Seconds() - t1;
    insert_s += t1 - t0;
    if (found.empty()) continue;
    answers.push_back({found.front().score, study.same_place[i][found.front().keyframe.value - 1]});
  }
  Report("index", study, answers, insert_s, query_s);
}

// A tree of k-medians (majority of bits), words weighted by log(N / n), L1 score of normalised
// vectors (Nister and Stewenius 2006).
class VocabularyTree {
 public:
  void Train(const std::vector<Descriptors>& images) {
    Descriptors all;
    for (const auto& image : images) all.insert(all.end(), image.begin(), image.end());
    nodes_.push_back({});
    Split(0, all, 0);
  }
  int Word(const Descriptor& d) const {
    int at = 0;
    while (!nodes_[at].children.empty()) {
      int best = 1000, next = 0;
      for (const int child : nodes_[at].children) {
        const int distance = HammingDistance(d, nodes_[child].centre);
        if (distance < best) best = distance, next = child;
      }
      at = next;
    }
    return at;
  }

 private:
  static constexpr int kBranches = 10, kDepth = 4, kRounds = 8;
  struct Node {
    Descriptor centre{};
    std::vector<int> children;
  };
  void Split(int node, const Descriptors& members, int depth) {
    if (depth == kDepth || members.size() <= kBranches) return;
    CounterRng rng(1, 7, static_cast<uint64_t>(node));
    Descriptors centres;
    for (int k = 0; k < kBranches; ++k) {
      centres.push_back(members[rng.Below(static_cast<uint32_t>(members.size()))]);
    }
    std::vector<Descriptors> parts;
    for (int round = 0; round < kRounds; ++round) {
      parts.assign(kBranches, {});
      for (const Descriptor& d : members) {
        int best = 1000, chosen = 0;
        for (int k = 0; k < kBranches; ++k) {
          const int distance = HammingDistance(d, centres[k]);
          if (distance < best) best = distance, chosen = k;
        }
        parts[chosen].push_back(d);
      }
      for (int k = 0; k < kBranches; ++k) {
        if (parts[k].empty()) continue;
        std::array<size_t, 256> ones{};
        for (const Descriptor& d : parts[k]) {
          for (int bit = 0; bit < 256; ++bit) ones[bit] += d[bit / 64] >> (bit % 64) & 1;
        }
        centres[k] = {};
        for (int bit = 0; bit < 256; ++bit) {
          if (2 * ones[bit] > parts[k].size()) centres[k][bit / 64] |= uint64_t{1} << (bit % 64);
        }
      }
    }
    for (int k = 0; k < kBranches; ++k) {
      if (parts[k].empty()) continue;
      const int child = static_cast<int>(nodes_.size());
      nodes_.push_back({centres[k], {}});
      nodes_[node].children.push_back(child);
      Split(child, parts[k], depth + 1);
    }
  }
  std::vector<Node> nodes_;
};

void RunTree(const Study& study, const std::vector<Descriptors>& training) {
  VocabularyTree tree;
  tree.Train(training);
  std::map<int, double> idf;
  for (const auto& image : training) {
    std::map<int, bool> seen;
    for (const auto& d : image) seen[tree.Word(d)] = true;
    for (const auto& [word, yes] : seen) idf[word] += 1;
  }
  for (auto& [word, n] : idf) n = std::log(static_cast<double>(training.size()) / n);
  std::vector<std::map<int, double>> vectors;
  std::vector<Answer> answers;
  double insert_s = 0, query_s = 0;
  for (size_t i = 0; i < study.images.size(); ++i) {
    const double t0 = Seconds();
    std::map<int, double> v;
    for (const auto& d : study.images[i]) {
      const int word = tree.Word(d);
      v[word] += idf.contains(word) ? idf[word] : std::log(static_cast<double>(training.size()));
    }
    double norm = 0;
    for (const auto& [word, w] : v) norm += w;
    for (auto& [word, w] : v) w /= norm;
    vectors.push_back(v);
    const double t1 = Seconds();
    Answer best;
    for (size_t j = 0; j + study.recent < i; ++j) {
      double score = 0;
      for (const auto& [word, w] : vectors[j]) {
        const auto it = v.find(word);
        if (it != v.end()) score += std::min(w, it->second);
      }
      if (score > best.score) best = {score, study.same_place[i][j]};
    }
    query_s += Seconds() - t1;
    insert_s += t1 - t0;
    if (best.score > 0) answers.push_back(best);
  }
  Report("tree", study, answers, insert_s, query_s);
}

Study Read(const std::vector<std::string>& a, size_t* at) {
  if (*at + 1 < a.size() && a[*at] == "photos") {
    *at += 2;
    return ReadPhotos(a[*at - 1]);
  }
  if (*at + 2 < a.size() && a[*at] == "log") {
    *at += 3;
    return ReadLog(a[*at - 2], a[*at - 1]);
  }
  return {};
}

}  // namespace
}  // namespace gw::tools

int main(int argc, char** argv) {
  using namespace gw::tools;  // NOLINT(google-build-using-namespace)
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  size_t at = 0;
  const Study study = Read(arguments, &at);
  if (study.images.empty()) {
    std::fprintf(stderr,
                 "usage: place_study {photos DIR | log LOG.lcm ROBOT.yaml} [--train {photos DIR | "
                 "log LOG.lcm ROBOT.yaml}]\n");
    return 2;
  }
  std::vector<Descriptors> training = study.images;
  if (at < arguments.size() && arguments[at] == "--train") {
    training = Read(arguments, &++at).images;
  }
  RunIndex(study);
  RunTree(study, training);
  return 0;
}

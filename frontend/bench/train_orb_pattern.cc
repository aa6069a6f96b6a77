// Trains the descriptor's pattern and prints it as frontend/core/features/orb_pattern_table.cc:
//
//   train_orb_pattern IMAGE... > frontend/core/features/orb_pattern_table.cc
//
// The shipped table was made from the 84 photographs of place_recognition_84, every fifth left
// image of kitti_stereo_51, and the left images 20 and 40 of euroc_v101_static.
//
// As Rublee, Rabaud, Konolige, Bradski, "ORB", ICCV 2011, do, tests are taken greedily from many
// random ones, best first, unless they correlate with one already taken. Best here means not only a
// bit that is balanced over all patches, but also one that keeps its value when the camera moves:
// every image is seen a second time, turned, scaled, sheared, blurred and with noise, and a bit
// that differs between two views of one corner counts against the test.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "common/core/random.h"
#include "frontend/core/features/image_test_pattern.h"
#include "frontend/core/features/orb_extractor.h"

namespace gw::frontend {
namespace {

constexpr uint64_t kSeed = 1;
constexpr int kNumCandidates = 24000;
constexpr int kNumTextures = 8;
constexpr int kNumAngles = 128;
constexpr double kMaxCorrelationStep = 0.02;

struct View {
  cv::Mat gray;
  cv::Matx23d from_first;  // pixel of the first view -> pixel of this one
};

View SecondView(const cv::Mat& image, CounterRng* rng) {
  const double turn = rng->Uniform(-0.6, 0.6);
  const double scale = rng->Uniform(0.87, 1.15);
  const double shear = rng->Uniform(-0.12, 0.12);
  const cv::Matx22d a =
      cv::Matx22d(std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn)) *
      cv::Matx22d(scale, shear, shear, scale / (1 + std::abs(shear)));
  const cv::Vec2d center(0.5 * image.cols, 0.5 * image.rows);
  const cv::Vec2d shift = center - a * center;
  View view;
  view.from_first = {a(0, 0), a(0, 1), shift[0], a(1, 0), a(1, 1), shift[1]};
  cv::warpAffine(image, view.gray, view.from_first, image.size(), cv::INTER_AREA,
                 cv::BORDER_REFLECT_101);
  return view;
}

// Motion blur, brightness and noise.
void Spoil(cv::Mat* gray, CounterRng* rng) {
  const int length = static_cast<int>(rng->Below(9));
  if (length > 1) {
    cv::Mat kernel = cv::Mat::zeros(9, 9, CV_32F);
    const double direction = rng->Uniform(0, std::numbers::pi);
    for (double s = -0.5 * length; s <= 0.5 * length; s += 0.25) {
      kernel.at<float>(static_cast<int>(std::lround(4 + s * std::sin(direction))),
                       static_cast<int>(std::lround(4 + s * std::cos(direction)))) += 1;
    }
    kernel /= cv::sum(kernel)[0];
    cv::filter2D(*gray, *gray, -1, kernel);
  }
  const double gain = rng->Uniform(0.8, 1.2);
  const double noise = rng->Uniform(1, 4);
  for (int y = 0; y < gray->rows; ++y) {
    for (int x = 0; x < gray->cols; ++x) {
      uint8_t& p = gray->at<uint8_t>(y, x);
      p = cv::saturate_cast<uint8_t>(gain * p + noise * rng->Normal());
    }
  }
}

struct Candidates {
  std::vector<OrbTest> tests;
  std::vector<int16_t> points;  // [angle][test][ax, ay, bx, by]
};

Candidates MakeCandidates() {
  CounterRng rng(kSeed, 1, 0);
  Candidates c;
  const auto draw = [&rng](int8_t* x, int8_t* y) {
    do {
      *x = static_cast<int8_t>(std::lround(7.5 * rng.Normal()));
      *y = static_cast<int8_t>(std::lround(7.5 * rng.Normal()));
    } while (std::hypot(*x, *y) > kOrbPatchRadius - 0.5);
  };
  while (c.tests.size() < kNumCandidates) {
    OrbTest t;
    draw(&t.ax, &t.ay);
    draw(&t.bx, &t.by);
    if (std::hypot(t.ax - t.bx, t.ay - t.by) >= 2) c.tests.push_back(t);
  }
  for (int k = 0; k < kNumAngles; ++k) {
    const double angle = 2 * std::numbers::pi * k / kNumAngles;
    const double co = std::cos(angle), si = std::sin(angle);
    for (const OrbTest& t : c.tests) {
      for (const auto& [x, y] : {std::pair{t.ax, t.ay}, std::pair{t.bx, t.by}}) {
        c.points.push_back(static_cast<int16_t>(std::lround(co * x - si * y)));
        c.points.push_back(static_cast<int16_t>(std::lround(si * x + co * y)));
      }
    }
  }
  return c;
}

// One bit a patch, for each candidate.
using Bits = std::vector<std::vector<uint64_t>>;

void AddBits(const Candidates& c, const ImageBuffer& image, const OrbKeypoint& k, size_t index,
             Bits* bits) {
  const int angle = static_cast<int>(std::lround(k.angle * kNumAngles / (2 * std::numbers::pi))) &
                    (kNumAngles - 1);
  const int16_t* p = c.points.data() + static_cast<size_t>(angle) * c.tests.size() * 4;
  const uint8_t* center =
      image.row(static_cast<int>(std::lround(k.y))) + static_cast<int>(std::lround(k.x));
  for (size_t t = 0; t < c.tests.size(); ++t, p += 4) {
    const bool bit = center[p[1] * image.stride + p[0]] < center[p[3] * image.stride + p[2]];
    std::vector<uint64_t>& words = (*bits)[t];
    if (words.size() <= index / 64) words.resize(index / 64 + 1, 0);
    words[index / 64] |= static_cast<uint64_t>(bit) << (index % 64);
  }
}

int Main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::vector<cv::Mat> images;
  for (int i = 1; i < argc; ++i) {
    cv::Mat image = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (image.empty()) continue;
    if (image.cols > 800) cv::resize(image, image, {}, 0.5, 0.5, cv::INTER_AREA);
    images.push_back(image);
  }
  for (uint64_t s = 0; s < kNumTextures; ++s) {
    const ImageBuffer t = Render(CellTexture(s, 6 + 2.0 * static_cast<double>(s)), 640, 480,
                                 [](double u, double v) { return Eigen::Vector2d(u, v); });
    images.push_back(
        cv::Mat(480, 640, CV_8UC1, const_cast<uint8_t*>(t.row(0)), static_cast<size_t>(t.stride))
            .clone());
  }
  const Candidates candidates = MakeCandidates();
  Bits first(candidates.tests.size()), second(candidates.tests.size());
  size_t num_patches = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    CounterRng rng(kSeed, 2, i);
    View view = SecondView(images[i], &rng);
    cv::Mat gray = images[i].clone();
    Spoil(&gray, &rng);
    Spoil(&view.gray, &rng);
    OrbConfig config;
    config.num_features = 400;
    OrbExtractor a = OrbExtractor::Create(config, gray.cols, gray.rows).value();
    OrbExtractor b = OrbExtractor::Create(config, gray.cols, gray.rows).value();
    std::vector<OrbKeypoint> ka, kb;
    std::vector<Descriptor> unused;
    a.Extract({gray.data, gray.cols, gray.rows, static_cast<int>(gray.step), PixelFormat::kGray8},
              nullptr, &ka, &unused);
    b.Extract({view.gray.data, gray.cols, gray.rows, static_cast<int>(view.gray.step),
               PixelFormat::kGray8},
              nullptr, &kb, &unused);
    for (const OrbKeypoint& k : ka) {
      const cv::Vec2d moved = view.from_first * cv::Vec3d(k.u, k.v, 1);
      const OrbKeypoint* best = nullptr;
      double best_distance = 2.0 * std::pow(1.2, k.level);
      for (const OrbKeypoint& q : kb) {
        if (std::abs(q.level - k.level) > 1) continue;
        const double d = std::hypot(q.u - moved[0], q.v - moved[1]);
        if (d >= best_distance) continue;
        best_distance = d;
        best = &q;
      }
      if (best == nullptr) continue;
      AddBits(candidates, a.pyramid().level(k.level), k, num_patches, &first);
      AddBits(candidates, b.pyramid().level(best->level), *best, num_patches, &second);
      ++num_patches;
    }
  }
  std::fprintf(stderr, "%zu pairs of patches from %zu images\n", num_patches, images.size());

  const double n = static_cast<double>(num_patches);
  struct Rank {
    size_t test;
    double mean, value;
  };
  std::vector<Rank> ranks;
  for (size_t t = 0; t < candidates.tests.size(); ++t) {
    double ones = 0, differ = 0;
    for (size_t w = 0; w < first[t].size(); ++w) {
      ones += std::popcount(first[t][w]);
      differ += std::popcount(first[t][w] ^ second[t][w]);
    }
    const double mean = ones / n;
    // Chance that two random patches differ, less that two views of one patch do.
    ranks.push_back({t, mean, 2 * mean * (1 - mean) - differ / n});
  }
  std::stable_sort(ranks.begin(), ranks.end(),
                   [](const Rank& x, const Rank& y) { return x.value > y.value; });
  std::vector<Rank> taken;
  for (double limit = 0.3; taken.size() < 256; limit += kMaxCorrelationStep) {
    taken.clear();
    for (const Rank& r : ranks) {
      const bool correlated = std::any_of(taken.begin(), taken.end(), [&](const Rank& s) {
        double both = 0;
        for (size_t w = 0; w < first[r.test].size(); ++w) {
          both += std::popcount(first[r.test][w] & first[s.test][w]);
        }
        const double covariance = both / n - r.mean * s.mean;
        return std::abs(covariance) >
               limit * std::sqrt(r.mean * (1 - r.mean) * s.mean * (1 - s.mean));
      });
      if (!correlated) taken.push_back(r);
      if (taken.size() == 256) break;
    }
  }
  std::printf(
      "// Generated by train_orb_pattern (frontend/bench) from its rendered textures and %zu\n"
      "// photographs; %zu pairs of patches. Do not edit.\n"
      "#include \"frontend/core/features/orb_pattern.h\"\n\nnamespace gw::frontend {\n\n"
      "const OrbPattern kOrbPattern = {{\n",
      images.size() - kNumTextures, num_patches);
  for (const Rank& r : taken) {
    const OrbTest& t = candidates.tests[r.test];
    std::printf("{%d, %d, %d, %d},\n", t.ax, t.ay, t.bx, t.by);
  }
  std::printf("}};\n\n}  // namespace gw::frontend\n");
  return 0;
}

}  // namespace
}  // namespace gw::frontend

int main(int argc, char** argv) {
  return gw::frontend::Main(argc, argv);
}

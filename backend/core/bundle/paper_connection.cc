#include "backend/core/bundle/paper_connection.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/good_weights/alpha.h"

namespace gw::backend {
namespace {

constexpr double kInitialReference = 20;  // the paper, section IV
constexpr int kReach = 3;                 // keyframes of the window before and after
// Landmarks that make a link of the covisibility graph, as in Mur-Artal and Tardos, "ORB-SLAM2",
// whose graph the paper's system uses.
constexpr int kLink = 15;

// The chain around `centre`, in order of time, and where in it `centre` is.
std::vector<const MapKeyframe*> Window(const Map& map, const MapKeyframe& centre, size_t* at) {
  std::vector<const MapKeyframe*> out;
  const MapKeyframe* k = &centre;
  for (int i = 0; i < kReach; ++i) {
    k = map.FindKeyframe(k->frame.previous);
    if (k == nullptr) break;
    out.push_back(k);
  }
  std::reverse(out.begin(), out.end());
  *at = out.size();
  out.push_back(&centre);
  k = &centre;
  for (int i = 0; i < kReach; ++i) {
    k = map.FindKeyframe(k->next);
    if (k == nullptr) break;
    out.push_back(k);
  }
  return out;
}

// Hops from window[at] to each of the window, over links of covisibility and of time.
std::vector<int> Hops(const Map& map, const std::vector<const MapKeyframe*>& window, size_t at) {
  const auto linked = [&](size_t a, size_t b) {
    return a + 1 == b || b + 1 == a ||
           map.SharedLandmarks(window[a]->frame.id, window[b]->frame.id) >= kLink;
  };
  std::vector<int> hops(window.size(), -1);
  hops[at] = 0;
  std::vector<size_t> queue{at};
  for (size_t next = 0; next < queue.size(); ++next) {
    for (size_t i = 0; i < window.size(); ++i) {
      if (hops[i] >= 0 || !linked(queue[next], i)) continue;
      hops[i] = hops[queue[next]] + 1;
      queue.push_back(i);
    }
  }
  return hops;
}

}  // namespace

double PaperConnectionReference(const Map& map, const DrWeightConfig& config,
                                const std::function<double(const MapKeyframe&)>& connection) {
  const auto well_tracked = [&](const MapKeyframe& k) {
    return k.frame.num_tracked >= config.n_trk_ref && map.FindKeyframe(k.frame.previous) != nullptr;
  };
  const auto& keyframes = map.keyframes();
  const auto newest = std::find_if(keyframes.rbegin(), keyframes.rend(),
                                   [&](const auto& k) { return well_tracked(k.second); });
  if (newest == keyframes.rend()) return kInitialReference;
  std::vector<double> counts{connection(newest->second)};
  for (const auto& [id, shared] : map.Neighbours(newest->first, kLink)) {
    const MapKeyframe& neighbour = *map.FindKeyframe(id);
    if (well_tracked(neighbour)) counts.push_back(connection(neighbour));
  }
  std::sort(counts.begin(), counts.end());
  const size_t n = counts.size();
  return std::max(1.0, 0.5 * (counts[(n - 1) / 2] + counts[n / 2]));
}

double PaperSmoothedLack(const Map& map, const MapKeyframe& centre, const DrWeightConfig& config,
                         const std::function<double(const MapKeyframe&)>& lack) {
  const double range = std::log(config.alpha_max / config.alpha_min);
  if (!(range > 0)) return lack(centre);
  size_t at = 0;
  const std::vector<const MapKeyframe*> window = Window(map, centre, &at);
  const std::vector<int> hops = Hops(map, window, at);
  double sum = 0;
  double weights = 0;
  for (size_t i = 0; i < window.size(); ++i) {
    if (!window[i]->frame.previous.valid()) continue;
    const double weight = std::ldexp(1.0, -hops[i]);
    sum += weight * InformationScale(1.0 - lack(*window[i]), config);
    weights += weight;
  }
  if (!(weights > 0)) return 0.0;
  return std::clamp(std::log(sum / weights / config.alpha_min) / range, 0.0, 1.0);
}

}  // namespace gw::backend

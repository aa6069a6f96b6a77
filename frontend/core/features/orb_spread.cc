#include "frontend/core/features/orb_spread.h"

#include <algorithm>
#include <cmath>

namespace gw::frontend {
namespace {

bool Stronger(const Corner& a, const Corner& b) {
  if (a.score != b.score) return a.score > b.score;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

}  // namespace

void OrbSpread::Select(int width, int height, int wanted, std::vector<Corner>* corners,
                       std::vector<Corner>* selected) {
  selected->clear();
  if (wanted <= 0 || corners->empty()) return;
  if (static_cast<int>(corners->size()) <= wanted) {
    *selected = *corners;
    return;
  }
  const auto begin = corners->begin();
  nodes_.assign(1, {0, 0, width, height, 0, static_cast<int>(corners->size())});
  const auto splittable = [](const Node& n) {
    return n.end - n.begin > 1 && (n.x1 - n.x0 > 1 || n.y1 - n.y0 > 1);
  };
  bool grew = true;
  while (grew && static_cast<int>(nodes_.size()) < wanted) {
    grew = false;
    // Fullest first, so that the last round, which ends when there are enough leaves, splits where
    // corners are many.
    order_.resize(nodes_.size());
    for (size_t i = 0; i < order_.size(); ++i) order_[i] = static_cast<int>(i);
    std::sort(order_.begin(), order_.end(), [this](int a, int b) {
      const Node& na = nodes_[static_cast<size_t>(a)];
      const Node& nb = nodes_[static_cast<size_t>(b)];
      const int ca = na.end - na.begin;
      const int cb = nb.end - nb.begin;
      return ca != cb ? ca > cb : a < b;
    });
    next_.clear();
    int leaves = static_cast<int>(nodes_.size());
    for (const int i : order_) {
      const Node node = nodes_[static_cast<size_t>(i)];
      if (leaves >= wanted || !splittable(node)) {
        next_.push_back(node);
        continue;
      }
      grew = true;
      const int xm = (node.x0 + node.x1) / 2;
      const int ym = (node.y0 + node.y1) / 2;
      const auto split = [&](int from, int to, auto is_first) {
        return static_cast<int>(std::partition(begin + from, begin + to, is_first) - begin);
      };
      const auto above = [ym](const Corner& c) { return c.y < ym; };
      const auto left = [xm](const Corner& c) { return c.x < xm; };
      const int middle = split(node.begin, node.end, above);
      const int upper = split(node.begin, middle, left);
      const int lower = split(middle, node.end, left);
      const Node children[] = {{node.x0, node.y0, xm, ym, node.begin, upper},
                               {xm, node.y0, node.x1, ym, upper, middle},
                               {node.x0, ym, xm, node.y1, middle, lower},
                               {xm, ym, node.x1, node.y1, lower, node.end}};
      --leaves;
      for (const Node& child : children) {
        if (child.begin == child.end) continue;
        next_.push_back(child);
        ++leaves;
      }
    }
    nodes_.swap(next_);
  }
  for (const Node& node : nodes_) {
    selected->push_back(*std::min_element(begin + node.begin, begin + node.end, Stronger));
  }
  // The last split may give up to three leaves too many.
  if (static_cast<int>(selected->size()) > wanted) {
    std::sort(selected->begin(), selected->end(), Stronger);
    selected->resize(static_cast<size_t>(wanted));
  }
}

}  // namespace gw::frontend

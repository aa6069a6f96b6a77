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

// Without branches, of which no processor foretells one that asks on which side a corner lies.
std::array<int, 5> OrbSpread::SplitInFour(int begin, int end, int xm, int ym,
                                          std::vector<Corner>* corners) {
  Corner* const first = corners->data() + begin;
  const auto n = static_cast<size_t>(end - begin);
  const auto quarter_of = [=](const Corner& c) {
    return static_cast<size_t>(c.y >= ym) * 2 + static_cast<size_t>(c.x >= xm);
  };
  std::array<int, 4> count{};
  for (size_t i = 0; i < n; ++i) ++count[quarter_of(first[i])];
  std::array<int, 5> parts{begin, 0, 0, 0, 0};
  for (size_t q = 0; q < 4; ++q) parts[q + 1] = parts[q] + count[q];
  std::array<int, 4> next;
  for (size_t q = 0; q < 4; ++q) next[q] = parts[q] - begin;
  split_.assign(first, first + n);
  for (const Corner& c : split_) first[next[quarter_of(c)]++] = c;
  return parts;
}

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
      const std::array<int, 5> parts = SplitInFour(node.begin, node.end, xm, ym, corners);
      const Node children[] = {{node.x0, node.y0, xm, ym, parts[0], parts[1]},
                               {xm, node.y0, node.x1, ym, parts[1], parts[2]},
                               {node.x0, ym, xm, node.y1, parts[2], parts[3]},
                               {xm, ym, node.x1, node.y1, parts[3], parts[4]}};
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

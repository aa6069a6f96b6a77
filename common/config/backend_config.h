// Tuning of the mapping back-end (section `backend`).
#pragma once

#include "common/core/fields.h"

namespace gw {

// Which keyframes local bundle adjustment moves.
enum class LocalWindow {
  kCovisible,  // those that share most landmarks with the newest
  kGoodGraph,  // those that keep the problem best conditioned (docs/method.md, section 6.4)
};

struct BackendConfig {
  LocalWindow local_ba = LocalWindow::kCovisible;
  int covisibility_min_shared = 15;
  int local_keyframes = 20;
  int local_fixed_keyframes = 20;
  int local_ba_iterations = 10;
  double redundant_share = 0.9;
  int redundant_observers = 3;
  double landmark_min_found_ratio = 0.25;
  int journal_sync_ms = 200;

  template <typename Visitor>
  void VisitFields(Visitor& v) {
    v.Enum("local_ba", local_ba,
           {{"covisible", LocalWindow::kCovisible}, {"good_graph", LocalWindow::kGoodGraph}},
           {.text = "which covisible keyframes local BA moves: those that share most with the "
                    "newest, or those that make its information largest"});
    v.Field("covisibility_min_shared", covisibility_min_shared,
            {.min = 1,
             .max = 1000,
             .unit = "count",
             .text = "shared landmarks that make two keyframes neighbours"});
    v.Field(
        "local_keyframes", local_keyframes,
        {.min = 2, .max = 200, .unit = "count", .text = "covisible keyframes that local BA moves"});
    v.Field("local_fixed_keyframes", local_fixed_keyframes,
            {.min = 1,
             .max = 500,
             .unit = "count",
             .text = "keyframes outside the window, seeing its landmarks, that hold local BA in "
                     "place"});
    v.Field(
        "local_ba_iterations", local_ba_iterations,
        {.min = 1, .max = 100, .unit = "count", .text = "solver iterations per pass of local BA"});
    v.Field(
        "redundant_share", redundant_share,
        {.min = 0.5,
         .max = 1,
         .text = "a keyframe goes when this share of its close landmarks is seen by enough others; "
                 "those that fewer see at all do not count"});
    v.Field("redundant_observers", redundant_observers,
            {.min = 2, .max = 20, .unit = "count", .text = "how many others are enough"});
    v.Field("landmark_min_found_ratio", landmark_min_found_ratio,
            {.min = 0,
             .max = 1,
             .text = "a young landmark goes when fewer of the keyframes that should see it do"});
    v.Field("journal_sync_ms", journal_sync_ms,
            {.min = 0,
             .max = 60000,
             .unit = "ms",
             .text = "longest time a map change may stay unsynced to disk"});
  }
};

}  // namespace gw

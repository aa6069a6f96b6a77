// gw-eval: compares an estimated trajectory with a reference.
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include "common/cli/command.h"
#include "common/core/exit_code.h"
#include "tools/data/files/text_file.h"
#include "tools/data/log/span.h"
#include "tools/lab/eval/report.h"
#include "tools/lab/eval/smooth_command.h"

namespace gw::eval {
namespace {

struct Arguments {
  std::string ref;
  std::string est;
  std::string keyframes;
  std::string frames;
  std::string span;
  int64_t images = 0;
  std::string json;
  std::string plot;
  double max_gap_s = 0.1;
  double max_diff_s = 0.02;
  double rpe_delta_s = 1.0;
  EvalOptions options;
};

// Leaves what lies in the span.
void Cut(Utime begin, const tools::Span& span, Trajectory* trajectory) {
  std::erase_if(*trajectory,
                [&](const TimedPose& pose) { return !span.Contains(pose.utime - begin); });
}

// Fills coverage from --frames or --images.
Result<Done> MeasureCoverage(const Arguments& args, const Trajectory& est, EvalReport* report) {
  if (!args.frames.empty()) {
    const auto frames = ReadFrameTimes(args.frames);
    if (!frames) return frames.error();
    if (frames->empty()) return Error{ErrorCode::kBadData, args.frames + ": holds no frame"};
    report->images = static_cast<int64_t>(frames->size());
    report->coverage = Coverage(*frames, est);
  } else if (args.images > 0) {
    const auto poses = static_cast<int64_t>(est.size());
    if (poses > args.images) {
      return Error{ErrorCode::kBadData, args.est + ": has " + std::to_string(poses) +
                                            " poses, more than --images " +
                                            std::to_string(args.images)};
    }
    report->images = args.images;
    report->coverage = static_cast<double>(poses) / static_cast<double>(args.images);
  }
  return Done{};
}

Result<Done> Run(const Arguments& args) {
  std::optional<tools::Span> span;
  if (!args.span.empty()) {
    const auto parsed = tools::ParseSpan("--span", args.span);
    if (!parsed) return parsed.error();
    span = parsed->span;
  }
  auto ref = ReadReference(args.ref);
  if (!ref) return ref.error();
  auto est = ReadTum(args.est);
  if (!est) return est.error();
  const Utime begin = ref->empty() ? Utime() : ref->front().utime;
  if (span) {
    Cut(begin, *span, &*ref);
    Cut(begin, *span, &*est);
  }
  EvalReport report;
  report.ref_name = args.ref;
  report.est_name = args.est;
  report.options = args.options;
  auto frames = Evaluate(*ref, *est, args.options);
  if (!frames) return Error{frames.error().code, args.est + ": " + frames.error().message};
  report.frames = std::move(*frames);
  if (!args.keyframes.empty()) {
    auto keyframes = ReadTum(args.keyframes);
    if (!keyframes) return keyframes.error();
    if (span) Cut(begin, *span, &*keyframes);
    auto evaluation = Evaluate(*ref, *keyframes, args.options);
    if (!evaluation) {
      return Error{evaluation.error().code, args.keyframes + ": " + evaluation.error().message};
    }
    report.keyframes = std::move(*evaluation);
  }
  if (const auto done = MeasureCoverage(args, *est, &report); !done) return done.error();
  std::fputs(RenderTable(report).c_str(), stdout);
  if (!args.json.empty()) {
    const auto done = tools::WriteTextFile(args.json, RenderJson(report));
    if (!done) return done.error();
  }
  if (args.plot.empty()) return Done{};
  return tools::WriteTextFile(args.plot, RenderPlot(report, *ref, *est));
}

}  // namespace
}  // namespace gw::eval

int main(int argc, char** argv) {
  using gw::eval::Alignment;
  gw::eval::Arguments args;
  gw::cli::Command app(
      "Compares an estimated trajectory with a reference (TUM files: t x y z qx qy qz qw).\n"
      "Both must be of the same body; scale is never estimated.\n"
      "Exit: 0 ok, 1 files not usable or nothing to compare, 2 usage.");
  app.RequireCommands(0, 1);
  gw::eval::SmoothArguments smooth_args;
  const gw::cli::Command* const smooth = gw::eval::AddSmoothCommand(&app, &smooth_args);
  app.AddOption("--ref", args.ref, "reference: TUM file, or LCM log (.lcm) with ground truth");
  app.AddOption("--est", args.est, "estimate: TUM file");
  app.AddChoice<Alignment>(
      "--align", args.options.alignment,
      {{"se3", Alignment::kSe3}, {"yaw", Alignment::kYaw}, {"none", Alignment::kNone}},
      "how the frames are brought together: se3 (default), yaw (turn about z and "
      "shift) or none");
  app.AddOption("--max-gap", args.max_gap_s,
                "s; the reference is interpolated between samples at most this far apart")
      ->ShowDefault()
      ->InRange(0.0, 1e6);
  app.AddOption("--max-diff", args.max_diff_s,
                "s; elsewhere its nearest sample is used, at most this far away")
      ->ShowDefault()
      ->InRange(0.0, 1e6);
  app.AddOption("--rpe-delta", args.rpe_delta_s, "s; time span of the relative pose error")
      ->ShowDefault()
      ->InRange(1e-3, 1e6);
  app.AddOption("--drift-lengths", args.options.segment_lengths_m,
                "m; lengths of the drift segments (KITTI: 100,200,...,800)")
      ->Separator(',')
      ->ShowDefault()
      ->InRange(1e-3, 1e6);
  app.AddOption("--keyframes", args.keyframes, "final keyframes (TUM), for R(F/KF)");
  auto* images = app.AddOption("--images", args.images, "number of images, for the coverage")
                     ->InRange(int64_t{1}, int64_t{1} << 40);
  auto* frames = app.AddOption("--frames", args.frames, "frames.csv of the run, for the coverage")
                     ->Excludes(images);
  app.AddOption("--span", args.span,
                "T0:T1, s since the reference begins: only this span, aligned on its own")
      ->Excludes(images)
      ->Excludes(frames);
  app.AddOption("--json", args.json, "write all numbers to this file");
  app.AddOption("--plot", args.plot, "draw both trajectories and the errors into this SVG");
  if (const auto exit = app.Parse(argc, argv)) return *exit;
  if (!smooth->given()) {
    if (args.ref.empty()) return app.Missing("--ref");
    if (args.est.empty()) return app.Missing("--est");
  }
  args.options.max_gap = gw::DurationFromSeconds(args.max_gap_s);
  args.options.max_diff = gw::DurationFromSeconds(args.max_diff_s);
  args.options.rpe_delta = gw::DurationFromSeconds(args.rpe_delta_s);
  const auto done = smooth->given() ? gw::eval::RunSmooth(smooth_args) : gw::eval::Run(args);
  if (done) return gw::kExitOk;
  std::fprintf(stderr, "%s\n", done.error().message.c_str());
  return gw::ExitCodeFor(done.error());
}

#include "tools/sim/demo/report.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "common/contract/tracking_names.h"
#include "common/core/format.h"
#include "common/core/version.h"
#include "frontend/core/features/orb_extractor.h"
#include "tools/data/files/json.h"
#include "tools/sim/demo/base64.h"
#include "tools/sim/demo/charts.h"
#include "tools/view/report/report_page.h"

namespace gw::demo {
namespace {

constexpr size_t kMostBlindImages = 3;
constexpr size_t kImages = 9;

constexpr char kStyle[] =
    "body{font:15px/1.45 sans-serif;margin:2em auto;max-width:1020px;color:#222;padding:0 1em}"
    "h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}"
    "table{border-collapse:collapse}td,th{padding:.2em .9em .2em 0;text-align:left;"
    "vertical-align:top;border-bottom:1px solid #e4e4e4}"
    "img{max-width:100%}.images{display:grid;grid-template-columns:repeat(3,1fr);gap:10px}"
    "figure{margin:0}figcaption{font-size:.85em;color:#444}";

using view::EscapeHtml;

using Facts = std::vector<std::pair<std::string, std::string>>;

std::string Row(const std::string& name, const std::string& value) {
  return "<tr><th>" + EscapeHtml(name) + "</th><td>" + EscapeHtml(value) + "</td></tr>\n";
}

std::string SvgImage(const std::string& svg, const std::string& what) {
  return "<img alt=\"" + what + "\" src=\"data:image/svg+xml;base64," + Base64(svg) + "\">\n";
}

std::string Section(const std::string& heading, const std::string& text,
                    const std::string& content) {
  const std::string lead = text.empty() ? "" : "<p>" + text + "</p>\n";
  return "<h2>" + heading + "</h2>\n" + lead + content;
}

Facts Numbers(const RunAnalysis& run, const tools::Monitor& monitor) {
  Facts out = {
      {"duration, way", FormatFixed(run.seconds(), 1) + " s, " + FormatFixed(run.way_m, 1) + " m"},
      {"images, with a pose", std::to_string(monitor.images()) + ", " +
                                  std::to_string(monitor.images() - monitor.images_without_pose())},
      {"vision blind",
       FormatFixed(run.blind_s, 1) + " s in " + std::to_string(run.blind.size()) + " spans"}};
  if (run.has_truth) {
    out.emplace_back("position error RMS, largest, at the end",
                     FormatFixed(run.error_rmse_m, 3) + " m, " + FormatFixed(run.error_max_m, 3) +
                         " m, " + FormatFixed(run.error_end_m, 3) +
                         " m (tied to the truth at the first image)");
  }
  const auto ms = [&monitor](double q) {
    return FormatFixed(static_cast<double>(monitor.LatencyQuantile(q)) * 1e-3, 1) + " ms";
  };
  out.emplace_back("latency, median and 99 %", ms(0.5) + ", " + ms(0.99));
  return out;
}

std::string FactsTable(const Facts& facts, const tools::Monitor& monitor) {
  std::string out = "<table>\n";
  for (const auto& [name, value] : facts) out += Row(name, value);
  for (const auto& [process, health] : monitor.NewestHealth()) {
    std::string text;
    for (const auto& [name, count] : health.counters) {
      if (count != 0) text += (text.empty() ? "" : ", ") + name + " " + std::to_string(count);
    }
    out += Row(process, (health.message.empty() ? "ok" : health.message) +
                            (text.empty() ? "" : "; " + text));
  }
  return out + "</table>\n";
}

std::string Events(const RunAnalysis& run, const tools::Monitor& monitor) {
  std::string out = "<table>\n";
  for (const wire::Note& note : monitor.notes()) {
    const double t = (note.utime - run.begin).seconds();
    out += "<tr><td>" + FormatFixed(t, 1) + " s</td><td>" + EscapeHtml(note.key) + "</td><td>" +
           EscapeHtml(note.text) + "</td></tr>\n";
  }
  return out + "</table>\n";
}

// From the middle of the first blind spans, and evenly over the run.
std::vector<size_t> Choose(const RunAnalysis& run,
                           const std::vector<ImageSamples::Sample>& samples) {
  std::set<size_t> chosen;
  const auto nearest = [&](double t) {
    size_t best = 0;
    const auto off = [&](size_t i) {
      return std::abs((samples[i].utime - run.begin).seconds() - t);
    };
    for (size_t i = 1; i < samples.size(); ++i) {
      if (off(i) < off(best)) best = i;
    }
    return best;
  };
  for (size_t i = 0; i < std::min(kMostBlindImages, run.blind.size()); ++i) {
    chosen.insert(nearest(0.5 * (run.blind[i].first + run.blind[i].second)));
  }
  for (size_t i = 0; chosen.size() < std::min(kImages, samples.size()) && i < samples.size(); ++i) {
    chosen.insert(nearest(run.seconds() * static_cast<double>(i) / (kImages - kMostBlindImages)));
  }
  return {chosen.begin(), chosen.end()};
}

Result<std::string> Picture(const ImageSamples::Sample& sample, const RunAnalysis& run,
                            const OrbConfig& orb) {
  const cv::Mat& grey = sample.left;
  auto extractor = frontend::OrbExtractor::Create(orb, grey.cols, grey.rows);
  if (!extractor) return extractor.error();
  std::vector<frontend::OrbKeypoint> keypoints;
  std::vector<Descriptor> descriptors;
  extractor->Extract(
      {grey.data, grey.cols, grey.rows, static_cast<int>(grey.step), PixelFormat::kGray8}, nullptr,
      &keypoints, &descriptors);
  cv::Mat picture;
  cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
  for (const frontend::OrbKeypoint& k : keypoints) {
    const double radius = 2 * std::pow(orb.scale_factor, k.level);
    cv::circle(picture, cv::Point2d(k.u, k.v), static_cast<int>(std::lround(radius)), {60, 220, 60},
               1, cv::LINE_AA);
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", picture, jpeg, {cv::IMWRITE_JPEG_QUALITY, 80});
  const double t = (sample.utime - run.begin).seconds();
  const auto frame = std::lower_bound(run.frames.begin(), run.frames.end(), t - 1e-3,
                                      [](const FramePoint& f, double when) { return f.t < when; });
  std::string caption = FormatFixed(t, 1) + " s: " + std::to_string(keypoints.size()) + " features";
  if (frame != run.frames.end() && std::abs(frame->t - t) < 1e-3) {
    caption += std::string(", ") + StatusName(frame->status) + ", Q " + FormatFixed(frame->q, 2);
  }
  return "<figure><img alt=\"camera image\" src=\"data:image/jpeg;base64," + Base64(jpeg) +
         "\"><figcaption>" + caption + "</figcaption></figure>\n";
}

Error NoPose() {
  return Error{ErrorCode::kBadData,
               "no image got a pose: is gw-frontend running, and does the camera see anything?"};
}

std::string Lead() {
  return std::string("Good Weights ") + Version() +
         ". Poses as they were published live, while the robot drove.";
}

}  // namespace

Result<std::string> RenderReport(const ReportInput& input, const std::string& page,
                                 std::vector<tools::Json> messages) {
  const RunAnalysis run = Analyse(*input.monitor);
  if (run.frames.empty()) return NoPose();
  view::Report report;
  report.title = "Run of " + input.title;
  report.lead = Lead() +
                " Move along a chart: the robot and the image are where they were then. Draw a "
                "stretch of it to zoom, double click to see all again.";
  report.facts = Numbers(run, *input.monitor);
  report.messages = std::move(messages);
  report.figures = {FloorChart(run, input.map).json, LatencyChart(run).json};
  return view::RenderReport(page, report);
}

Result<std::string> RenderPlainReport(const ReportInput& input) {
  const RunAnalysis run = Analyse(*input.monitor);
  if (run.frames.empty()) return NoPose();
  std::string pictures;
  for (const size_t i : Choose(run, input.images->samples())) {
    const auto picture = Picture(input.images->samples()[i], run, input.orb);
    if (!picture) return picture.error();
    pictures += *picture;
  }
  const std::string title = EscapeHtml("Run of " + input.title);
  std::string page = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                     title + "</title><style>" + kStyle + "</style></head><body>\n<h1>" + title +
                     "</h1>\n<p>" + Lead() + "</p>\n" + view::kPlainNote;
  page += FactsTable(Numbers(run, *input.monitor), *input.monitor);
  page += Section("The way", "Where the camera was blind, dead reckoning alone carried the pose.",
                  SvgImage(FloorChart(run, input.map).svg, "way on the floor map"));
  page +=
      Section("Over time",
              "Q falls when the image shows too little or too little of it is matched; alpha then "
              "raises the weight of dead reckoning. Shaded: vision is blind.",
              SvgImage(TimeChart(run).svg, "Q, alpha and error over time"));
  page += Section("Latency", "", SvgImage(LatencyChart(run).svg, "histogram of latency"));
  page += Section("What the camera saw", "Circles: features, as large as their pyramid level.",
                  "<div class=\"images\">\n" + pictures + "</div>\n");
  page += Section("Events", "", Events(run, *input.monitor));
  return page + "</body></html>\n";
}

}  // namespace gw::demo

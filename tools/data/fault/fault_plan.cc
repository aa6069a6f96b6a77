#include "tools/data/fault/fault_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/wire/channels.h"
#include "tools/data/files/format.h"

namespace gw::fault {
namespace {

std::string SpanText(const tools::Span& span) {
  return span.end == tools::Span().end
             ? tools::Format("from %.6f s", span.begin.seconds())
             : tools::Format("%.6f s to %.6f s", span.begin.seconds(), span.end.seconds());
}

bool CanBeDelayed(const std::string& channel) {
  return channel == wire::kCamera || channel == wire::kImu || channel == wire::kWheel ||
         channel == wire::kDr || channel == wire::kGroundTruth;
}

Result<Done> ParseDelay(const std::string& text, FaultPlan& plan) {
  const size_t colon = text.find(':');
  const std::string channel = text.substr(0, colon);
  double ms = 0;
  const char* const end = text.data() + text.size();
  const char* const begin = colon == std::string::npos ? end : text.data() + colon + 1;
  const auto [next, status] = std::from_chars(begin, end, ms);
  if (status != std::errc() || next != end || !(ms >= 0 && ms <= 1e6)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--delay " + text + ": expected CHANNEL:MS, MS from 0 to 1e6"};
  }
  if (!CanBeDelayed(channel)) {
    return Error{ErrorCode::kInvalidArgument,
                 "--delay " + text + ": there are CAMERA, IMU, WHEEL, DR and GROUND_TRUTH"};
  }
  plan.delay[channel] = DurationFromSeconds(ms * 1e-3);
  return Done{};
}

Error OutOfRange(const std::string& option, const std::string& text, const std::string& rule) {
  return {ErrorCode::kInvalidArgument, option + " " + text + ": " + rule};
}

}  // namespace

Result<FaultPlan> ParseFaultPlan(const FaultArguments& arguments) {
  FaultPlan plan;
  plan.seed = arguments.seed;
  plan.gyro_bias_rad_s = arguments.gyro_bias_rad_s;
  if (!std::isfinite(plan.gyro_bias_rad_s)) {
    return OutOfRange("--gyro-bias", "", "must be a finite number");
  }
  for (const auto& [option, texts, spans] : {std::tuple{"--black", &arguments.black, &plan.black},
                                             {"--freeze", &arguments.freeze, &plan.freeze},
                                             {"--teleport", &arguments.teleport, &plan.teleport}}) {
    for (const std::string& text : *texts) {
      const Result<tools::SpanArgument> parsed = tools::ParseSpan(option, text);
      if (!parsed) return parsed.error();
      spans->push_back(parsed->span);
    }
  }
  for (const std::string& text : arguments.blur) {
    const Result<tools::SpanArgument> parsed = tools::ParseSpan("--blur", text, 1, 1);
    if (!parsed) return parsed.error();
    const double sigma = parsed->values[0];
    if (sigma <= 0 || sigma > 100)
      return OutOfRange("--blur", text, "SIGMA: above 0, up to 100 px");
    plan.blur.push_back({parsed->span, sigma});
  }
  for (const std::string& text : arguments.drop) {
    const Result<tools::SpanArgument> parsed = tools::ParseSpan("--drop", text, 0, 1);
    if (!parsed) return parsed.error();
    const double probability = parsed->values.empty() ? 1 : parsed->values[0];
    if (probability > 1) return OutOfRange("--drop", text, "P is a probability, 0 to 1");
    plan.drop.push_back({parsed->span, probability});
  }
  for (const std::string& text : arguments.slip) {
    const Result<tools::SpanArgument> parsed = tools::ParseSpan("--slip", text, 1, 1);
    if (!parsed) return parsed.error();
    if (parsed->values[0] > 100) return OutOfRange("--slip", text, "FACTOR: 0 to 100");
    plan.slip.push_back({parsed->span, parsed->values[0]});
  }
  for (const std::string& text : arguments.delay) {
    const Result<Done> parsed = ParseDelay(text, plan);
    if (!parsed) return parsed.error();
  }
  std::sort(plan.teleport.begin(), plan.teleport.end(),
            [](const tools::Span& a, const tools::Span& b) { return a.begin < b.begin; });
  for (size_t i = 0; i < plan.teleport.size(); ++i) {
    if (plan.teleport[i].end == tools::Span().end) {
      return OutOfRange("--teleport", SpanText(plan.teleport[i]), "needs an end");
    }
    if (i > 0 && plan.teleport[i].begin < plan.teleport[i - 1].end) {
      return OutOfRange("--teleport", SpanText(plan.teleport[i]), "spans must not overlap");
    }
  }
  for (const std::string& text : arguments.fault) {
    const Result<NamedFault> parsed = ParseNamedFault(text);
    if (!parsed) return parsed.error();
    plan.named.push_back(*parsed);
  }
  if (plan.Describe().empty()) {
    return Error{ErrorCode::kInvalidArgument, "no edit is asked for; see gw-fault --help"};
  }
  return plan;
}

std::vector<std::pair<std::string, std::string>> FaultPlan::Describe() const {
  std::vector<std::pair<std::string, std::string>> out;
  for (const tools::Span& s : black) out.emplace_back("edit.black", SpanText(s));
  for (const tools::Span& s : freeze) out.emplace_back("edit.freeze", SpanText(s));
  for (const Blur& b : blur) {
    out.emplace_back("edit.blur", SpanText(b.span) + tools::Format(", sigma %g px", b.sigma_px));
  }
  for (const Drop& d : drop) {
    out.emplace_back("edit.drop",
                     SpanText(d.span) + tools::Format(", probability %g, seed %llu", d.probability,
                                                      static_cast<unsigned long long>(seed)));
  }
  for (const auto& [channel, duration] : delay) {
    out.emplace_back("edit.delay", channel + tools::Format(" by %g ms", duration.seconds() * 1e3));
  }
  for (const Slip& s : slip) {
    out.emplace_back("edit.slip",
                     SpanText(s.span) + tools::Format(", measured way times %g", s.factor));
  }
  if (gyro_bias_rad_s != 0) {
    out.emplace_back("edit.gyro_bias", tools::Format("%g rad/s on each axis", gyro_bias_rad_s));
  }
  for (const tools::Span& s : teleport) out.emplace_back("edit.teleport", SpanText(s));
  for (const NamedFault& fault : named) {
    const FaultKind& kind = fault.kind();
    out.emplace_back("edit.fault." + std::string(kind.name),
                     SpanText(fault.span) + ": " + std::string(kind.text));
  }
  return out;
}

}  // namespace gw::fault

#include "tools/lab/slam/variant.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace gw::tools {
namespace {

constexpr std::pair<const char*, Variant> kNames[] = {
    {"none", Variant::kNone},    {"da", Variant::kDa},     {"pe", Variant::kPe},
    {"lba", Variant::kLba},      {"full", Variant::kFull}, {"fixed", Variant::kFixed},
    {"switch", Variant::kSwitch}};

constexpr std::string_view kPaper = "paper:";
constexpr std::string_view kOurs = "ours:";
constexpr std::string_view kFixed = "fixed:";

Error BadVariant(const std::string& text, const std::string& what) {
  return Error{ErrorCode::kInvalidArgument,
               "variant " + text + ": " + what +
                   "use none, da, pe, lba, full, switch or fixed:ALPHA (0 to 1e12), with paper: or "
                   "ours: before it, and +DEPARTURE or -DEPARTURE after it"};
}

// Takes the name off the begin of `rest`. False: there is none.
bool TakeName(std::string_view* rest, FrontendConfig* config) {
  if (rest->starts_with(kFixed)) {
    const std::string number(rest->substr(kFixed.size()));
    char* end = nullptr;
    const double alpha = std::strtod(number.c_str(), &end);
    if (end == number.c_str() || !(alpha >= 0 && alpha <= 1e12)) return false;
    config->variant = Variant::kFixed;
    config->dr_weight.fixed_alpha = alpha;
    rest->remove_prefix(kFixed.size() + static_cast<size_t>(end - number.c_str()));
    return true;
  }
  const std::string_view name = rest->substr(0, rest->find_first_of("+-"));
  const auto* found = std::find_if(std::begin(kNames), std::end(kNames),
                                   [&](const auto& n) { return name == n.first; });
  if (found == std::end(kNames) || found->second == Variant::kFixed) return false;
  config->variant = found->second;
  rest->remove_prefix(name.size());
  return true;
}

// One change; `rest` begins with its sign. Empty when it can be made, else what is wrong with it.
std::string TakeChange(std::string_view* rest, DrWeightConfig* config) {
  const bool more = rest->front() == '+';
  if (!more && rest->front() != '-') return "something follows the name; ";
  const std::string_view name = rest->substr(1, rest->find_first_of("+-", 1) - 1);
  const auto* found = std::find_if(kDepartures.begin(), kDepartures.end(),
                                   [&](const auto& d) { return name == d.name; });
  if (found == kDepartures.end()) return "no departure is called \"" + std::string(name) + "\"; ";
  if (config->Departs(found->departure) == more) {
    return "\"" + std::string(name) + "\" is " + (more ? "in" : "not in") + " it anyway; ";
  }
  config->changed.Insert(found->departure);
  rest->remove_prefix(1 + name.size());
  return "";
}

}  // namespace

Result<Done> ApplyVariant(const std::string& text, FrontendConfig* config) {
  FrontendConfig out = *config;
  out.dr_weight.changed = {};
  std::string_view rest = text;
  for (const auto& [prefix, method] : {std::pair(kPaper, Method::kPaper), {kOurs, Method::kOurs}}) {
    if (!rest.starts_with(prefix)) continue;
    out.dr_weight.method = method;
    rest.remove_prefix(prefix.size());
    break;
  }
  if (!TakeName(&rest, &out)) return BadVariant(text, "");
  while (!rest.empty()) {
    const std::string wrong = TakeChange(&rest, &out.dr_weight);
    if (!wrong.empty()) return BadVariant(text, wrong);
  }
  *config = out;
  return Done{};
}

std::string VariantName(const FrontendConfig& config) {
  const bool ours = config.dr_weight.method == Method::kOurs;
  std::string out(ours ? "" : kPaper);
  for (const auto& [name, value] : kNames) {
    if (value == config.variant) out += name;
  }
  for (const NamedDeparture& d : kDepartures) {
    if (config.dr_weight.changed.Contains(d.departure))
      out += (ours ? '-' : '+') + std::string(d.name);
  }
  return out;
}

}  // namespace gw::tools

#include "tools/lab/slam/variant.h"

#include <cstdlib>
#include <utility>

namespace gw::tools {
namespace {

constexpr std::pair<const char*, Variant> kNames[] = {
    {"none", Variant::kNone},    {"da", Variant::kDa},     {"pe", Variant::kPe},
    {"lba", Variant::kLba},      {"full", Variant::kFull}, {"fixed", Variant::kFixed},
    {"switch", Variant::kSwitch}};

}  // namespace

Result<Done> ApplyVariant(const std::string& text, FrontendConfig* config) {
  for (const auto& [name, variant] : kNames) {
    if (text == name && variant != Variant::kFixed) {
      config->variant = variant;
      return Done{};
    }
  }
  const std::string fixed = "fixed:";
  if (text.starts_with(fixed)) {
    const char* const begin = text.c_str() + fixed.size();
    char* end = nullptr;
    const double alpha = std::strtod(begin, &end);
    if (end != begin && *end == '\0' && alpha >= 0 && alpha <= 1e12) {
      config->variant = Variant::kFixed;
      config->dr_weight.fixed_alpha = alpha;
      return Done{};
    }
  }
  return Error{
      ErrorCode::kInvalidArgument,
      "variant " + text + ": use none, da, pe, lba, full, switch or fixed:ALPHA (0 to 1e12)"};
}

std::string VariantName(Variant variant) {
  for (const auto& [name, value] : kNames) {
    if (value == variant) return name;
  }
  return "";
}

}  // namespace gw::tools

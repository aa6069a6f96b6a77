#include "tools/data/foxglove/advice.h"

namespace gw::foxglove {

std::string AdviceFor(const Health& health) {
  if (health.state == HealthState::kOk) return "";
  for (const Advice& advice : kAdvice) {
    if ((advice.process.empty() || advice.process == health.process) &&
        health.message.find(advice.text) != std::string::npos) {
      return std::string(advice.action);
    }
  }
  return "";
}

std::string AdviceForSilent(const std::string& process) {
  std::string text(kSilentAction);
  for (size_t at = text.find("NAME"); at != std::string::npos; at = text.find("NAME", at)) {
    text.replace(at, 4, process);
  }
  return text;
}

}  // namespace gw::foxglove

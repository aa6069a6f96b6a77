#include "common/config/writer.h"

#include "common/config/describe.h"
#include "common/config/reference.h"
#include "common/core/hash.h"

namespace gw {
namespace {

bool SameValues(const FieldInfo& a, const FieldInfo& b) {
  if (a.value != b.value) return false;
  for (size_t i = 0; i < a.fields.size(); ++i) {
    if (!SameValues(a.fields[i], b.fields[i])) return false;
  }
  return true;
}

bool HasRequiredField(const FieldInfo& section) {
  for (const FieldInfo& field : section.fields) {
    if (field.spec.required) return true;
  }
  return false;
}

std::string Comment(const FieldInfo& field) {
  std::string out;
  const auto append = [&out](const std::string& part) {
    if (!part.empty()) out += (out.empty() ? "" : "; ") + part;
  };
  append(field.spec.unit);
  append(LegalValues(field));
  append(field.spec.text);
  return out.empty() ? "" : "  # " + out;
}

class Writer {
 public:
  Writer(bool all, bool comments) : all_(all), comments_(comments) {}

  void Section(const FieldInfo& section, const FieldInfo& defaults, int indent) {
    for (size_t i = 0; i < section.fields.size(); ++i) {
      const FieldInfo& field = section.fields[i];
      const bool changed = !SameValues(field, defaults.fields[i]);
      const bool optional_group =
          field.is_section && !field.spec.required && HasRequiredField(field);
      const bool wanted = field.spec.required || changed || (all_ && !optional_group);
      if (!wanted) continue;
      text_ += std::string(indent, ' ') + field.name + ":";
      if (!field.is_section) text_ += " " + field.value;
      if (comments_) text_ += Comment(field);
      text_ += "\n";
      if (field.is_section) Section(field, defaults.fields[i], indent + 2);
    }
  }
  const std::string& text() const { return text_; }

 private:
  bool all_;
  bool comments_;
  std::string text_;
};

std::string Body(const RobotConfig& config, bool all, bool comments) {
  Writer writer(all, comments);
  writer.Section(DescribeConfig(config), DescribeConfig(RobotConfig{}), 0);
  return writer.text();
}

}  // namespace

std::string WriteRobotConfig(const RobotConfig& config, ConfigText text) {
  return "# Configuration of one robot or recording. Every key: docs/configuration.md\n" +
         Body(config, text == ConfigText::kEffective, true);
}

uint64_t ConfigHash(const RobotConfig& config) {
  // Without comments, so that a better explanation does not change the hash.
  return Fnv1a(Body(config, true, false));
}

}  // namespace gw

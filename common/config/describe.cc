#include "common/config/describe.h"

#include <array>
#include <utility>

#include "common/core/format.h"

namespace gw {
namespace {

std::string Quoted(const std::string& text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      out += "\\x";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}

template <typename Range>
std::string FormatList(const Range& values) {
  std::string out = "[";
  for (const double v : values) {
    if (out.size() > 1) out += ", ";
    out += FormatDouble(v);
  }
  return out + "]";
}

class Describer {
 public:
  explicit Describer(std::vector<FieldInfo>* out) : out_(out) {}

  void Field(const char* name, const bool& value, const FieldSpec& spec) {
    Add(name, "bool", value ? "true" : "false", spec);
  }
  void Field(const char* name, const int& value, const FieldSpec& spec) {
    Add(name, "int", std::to_string(value), spec);
  }
  void Field(const char* name, const double& value, const FieldSpec& spec) {
    Add(name, "float", FormatDouble(value), spec);
  }
  void Field(const char* name, const std::string& value, const FieldSpec& spec) {
    Add(name, "string", Quoted(value), spec);
  }
  template <size_t N>
  void Field(const char* name, const std::array<double, N>& value, const FieldSpec& spec) {
    Add(name, std::to_string(N) + " floats", FormatList(value), spec);
  }
  template <typename E>
  void Enum(const char* name, const E& value, const EnumChoices<E>& choices,
            const FieldSpec& spec) {
    FieldInfo& field = Add(name, "enum", "", spec);
    for (const auto& [text, choice] : choices) {
      field.choices.emplace_back(text);
      if (choice == value) field.value = text;
    }
  }
  void Pose(const char* name, const SE3& T, const FieldSpec& spec) {
    const Eigen::Vector3d& p = T.translation();
    const Eigen::Quaterniond& q = T.rotation();
    Add(name, "pose",
        "{p: " + FormatList(std::array{p.x(), p.y(), p.z()}) +
            ", q_wxyz: " + FormatList(std::array{q.w(), q.x(), q.y(), q.z()}) + "}",
        spec);
  }
  template <typename S>
  void Section(const char* name, S& section, const FieldSpec& spec) {
    FieldInfo& field = Add(name, "section", "", spec);
    field.is_section = true;
    Describer inner(&field.fields);
    section.VisitFields(inner);
  }

 private:
  FieldInfo& Add(const char* name, std::string type, std::string value, const FieldSpec& spec) {
    FieldInfo field;
    field.name = name;
    field.type = std::move(type);
    field.value = std::move(value);
    field.spec = spec;
    return out_->emplace_back(std::move(field));
  }

  std::vector<FieldInfo>* out_;
};

}  // namespace

FieldInfo DescribeConfig(const RobotConfig& config) {
  RobotConfig copy = config;  // VisitFields serves loaders too and is therefore not const
  FieldInfo root;
  root.is_section = true;
  Describer describer(&root.fields);
  copy.VisitFields(describer);
  return root;
}

}  // namespace gw

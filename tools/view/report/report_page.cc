#include "tools/view/report/report_page.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/core/version.h"
#include "tools/data/files/json.h"

namespace gw::view {
namespace {

// The value of the script element "data" in tools/view/page/report.html.
constexpr char kPlace[] = "\"the data of the report\"";

// Within a script element the text must not end it.
std::string ForScript(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

std::string PageFolder(const std::string& name, const std::string& file) {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  for (const char* place : {"../share/good-weights/", "../tools/view/page/"}) {
    const auto folder = program.parent_path() / place / name;
    if (std::filesystem::exists(folder / file, error)) return folder.string();
  }
  return "";
}

std::string ReportTemplate() {
  const std::string folder = PageFolder("report", "report.html");
  if (folder.empty()) return "";
  std::ifstream file(folder + "/report.html", std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Result<std::string> RenderReport(const std::string& page, const Report& report) {
  const size_t at = page.find(kPlace);
  if (at == std::string::npos || page.find(kPlace, at + 1) != std::string::npos) {
    return Error{ErrorCode::kBadData, "report.html has no place for the data: build it again"};
  }
  tools::Json facts = tools::Json::array(), figures = tools::Json::array();
  for (const auto& [name, value] : report.facts) facts.push_back({name, value});
  for (const std::string& figure : report.figures) figures.push_back(tools::Json::parse(figure));
  const tools::Json data = {{"title", report.title},       {"lead", report.lead},
                            {"version", Version()},        {"facts", std::move(facts)},
                            {"messages", report.messages}, {"figures", std::move(figures)},
                            {"markdown", report.markdown}};
  return page.substr(0, at) + ForScript(tools::JsonLine(data)) +
         page.substr(at + sizeof(kPlace) - 1);
}

std::string EscapeHtml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else {
      out += c;
    }
  }
  return out;
}

std::string RenderPlainReport(const std::string& title, const std::vector<std::string>& drawings,
                              const std::string& markdown) {
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                    EscapeHtml(title) +
                    "</title></head>\n<body style=\"font-family:sans-serif;margin:2em\">\n<h1>" +
                    EscapeHtml(title) + "</h1>\n" + kPlainNote;
  for (const std::string& svg : drawings) out += "<div>" + svg + "</div>\n";
  return out + "<pre>" + EscapeHtml(markdown) + "</pre>\n</body></html>\n";
}

}  // namespace gw::view

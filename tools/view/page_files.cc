#include "tools/view/page_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace gw::view {
namespace {

std::string TypeOf(const std::filesystem::path& path) {
  static const std::map<std::string, std::string, std::less<>> kTypes{
      {".html", "text/html; charset=utf-8"}, {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},   {".svg", "image/svg+xml"},
      {".json", "application/json"},         {".png", "image/png"},
      {".txt", "text/plain; charset=utf-8"}};
  const auto type = kTypes.find(path.extension().string());
  return type == kTypes.end() ? "application/octet-stream" : type->second;
}

constexpr char kNoPage[] =
    "<!doctype html><meta charset=utf-8><title>gw-view</title><h1>gw-view</h1>"
    "<p>The page was not built: npm was missing, or the registry could not be reached. "
    "Install npm and build the target <code>gw_view_page</code>.</p>"
    "<p>The data is here all the same: open a Foxglove WebSocket connection to this address in "
    "Foxglove or Lichtblick.</p>";

}  // namespace

PageFiles PageFiles::WithoutPage() {
  PageFiles page;
  page.files_["/index.html"] = {kNoPage, "text/html; charset=utf-8"};
  return page;
}

Result<PageFiles> PageFiles::Load(const std::string& folder) {
  namespace fs = std::filesystem;
  PageFiles page;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (!fs::is_regular_file(it->symlink_status())) continue;
    std::ifstream file(it->path(), std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(file), {}};
    if (!file) return Error{ErrorCode::kIo, it->path().string() + ": cannot be read"};
    const std::string name = "/" + fs::relative(it->path(), folder).generic_string();
    page.files_[name] = {std::move(content), TypeOf(it->path())};
  }
  if (error) return Error{ErrorCode::kIo, folder + ": cannot be read: " + error.message()};
  if (!page.files_.contains("/index.html")) {
    return Error{ErrorCode::kNotFound, folder + ": holds no index.html"};
  }
  return page;
}

const PageFiles::File* PageFiles::Find(std::string_view target) const {
  const std::string_view path = target.substr(0, target.find_first_of("?#"));
  const auto file = files_.find(path == "/" ? std::string_view("/index.html") : path);
  return file == files_.end() ? nullptr : &file->second;
}

}  // namespace gw::view

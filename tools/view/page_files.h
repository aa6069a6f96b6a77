// The files of the page, read once: nothing else can be served, whatever path is asked for.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "common/core/result.h"

namespace gw::view {

class PageFiles {
 public:
  struct File {
    std::string content;
    std::string type;  // MIME
  };

  // One page that says how to build the other, and what to connect with instead.
  static PageFiles WithoutPage();
  // Every regular file below the folder; links are left out. Error kIo, kNotFound (no index.html).
  static Result<PageFiles> Load(const std::string& folder);

  // target: of a request; "/" is the index. Null: there is no such file.
  const File* Find(std::string_view target) const;
  size_t size() const { return files_.size(); }

 private:
  std::map<std::string, File, std::less<>> files_;  // by path, "/index.html"
};

}  // namespace gw::view

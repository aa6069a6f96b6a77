#include "tools/view/page_files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace gw::view {
namespace {

namespace fs = std::filesystem;

fs::path MakeFolder() {
  const char* base = std::getenv("TEST_TMPDIR");
  const fs::path root = fs::path(base == nullptr ? "." : base) / "page_files";
  fs::remove_all(root);
  fs::create_directories(root / "page/assets");
  std::ofstream(root / "secret.txt") << "secret";
  std::ofstream(root / "page/index.html") << "<p>page";
  std::ofstream(root / "page/assets/a.js") << "1";
  fs::create_symlink(root / "secret.txt", root / "page/link.txt");
  return root / "page";
}

TEST(PageFiles, ServesWhatIsInTheFolder) {
  const auto page = PageFiles::Load(MakeFolder().string());
  ASSERT_TRUE(page.ok());
  EXPECT_EQ(page->size(), 2u);
  ASSERT_NE(page->Find("/"), nullptr);
  EXPECT_EQ(page->Find("/?token=x")->content, "<p>page");
  EXPECT_EQ(page->Find("/assets/a.js")->type, "text/javascript; charset=utf-8");
}

TEST(PageFiles, ServesNothingElse) {
  const auto page = PageFiles::Load(MakeFolder().string());
  ASSERT_TRUE(page.ok());
  for (const char* target :
       {"/../secret.txt", "/link.txt", "/assets/../../secret.txt", "/assets", "/%2e%2e/secret.txt",
        "//etc/passwd", "", "secret.txt", "/..", "/assets/a.js/", "http://host/index.html"}) {
    EXPECT_EQ(page->Find(target), nullptr) << target;
  }
}

TEST(PageFiles, AFolderWithoutAPageIsAnError) {
  EXPECT_FALSE(PageFiles::Load("/nonexistent").ok());
  EXPECT_FALSE(PageFiles::Load((MakeFolder() / "assets").string()).ok());
  EXPECT_NE(PageFiles::WithoutPage().Find("/"), nullptr);
}

}  // namespace
}  // namespace gw::view

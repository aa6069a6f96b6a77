#include "tools/view/report/report_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/data/files/json.h"

namespace gw::view {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kTemplate[] = "<script id=\"data\">\"the data of the report\"</script><p>end";

std::string DataIn(const std::string& html) {
  const size_t from = html.find('>') + 1;
  return html.substr(from, html.find("</script>") - from);
}

TEST(Report, HoldsTheDataWhateverTextIsInIt) {
  Report report;
  report.title = "</script><script>alert(1)</script>";
  report.markdown = "a < b && \"c\" \\ d\n| e |";
  report.facts = {{"way", "3 m"}};
  report.messages = {tools::Json::array({"/log", {{"message", "<!-- x"}}})};
  const auto html = RenderReport(kTemplate, report);
  ASSERT_TRUE(html.ok()) << html.error().message;
  const auto data = tools::Json::parse(DataIn(*html));
  EXPECT_EQ(data["title"], report.title);
  EXPECT_EQ(data["markdown"], report.markdown);
  EXPECT_EQ(data["facts"][0][1], "3 m");
  EXPECT_EQ(data["messages"][0][1]["message"], "<!-- x");
  EXPECT_THAT(*html, Not(HasSubstr("<!--")));
  EXPECT_THAT(*html, HasSubstr("</script><p>end"));
}

TEST(Report, ANotherPageIsRefused) {
  EXPECT_FALSE(RenderReport("<p>", Report()).ok());
  EXPECT_FALSE(RenderReport(std::string(kTemplate) + kTemplate, Report()).ok());
}

TEST(Report, ThePlainFormSaysThatItIs) {
  const std::string html = RenderPlainReport("a <b>", {"<svg></svg>"}, "| x < y |");
  EXPECT_THAT(html, HasSubstr("a &lt;b>"));
  EXPECT_THAT(html, HasSubstr("<svg></svg>"));
  EXPECT_THAT(html, HasSubstr("| x &lt; y |"));
  EXPECT_THAT(html, HasSubstr("gw_view_page"));
}

TEST(Report, AFolderThatIsNotThereIsNone) {
  EXPECT_EQ(PageFolder("nothing", "index.html"), "");
}

}  // namespace
}  // namespace gw::view

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "server/http/route_table.h"
#include "server/http/static_files.h"

namespace photond {
namespace {

using Values = std::vector<std::string>;

TEST(RouteTable, MatchesWholeSegments) {
  EXPECT_EQ(match_path("/v1/jobs", "/v1/jobs"), Values{});
  EXPECT_EQ(match_path("/v1/jobs/{id}", "/v1/jobs/x.y"), Values{"x.y"});
  EXPECT_EQ(match_path("/v1/scenes/{id}.glb", "/v1/scenes/abc.glb"), Values{"abc"});
  EXPECT_EQ(match_path("/f/{rev}.{format}", "/f/12.png"), (Values{"12", "png"}));
  for (const char* path :
       {"", "/", "v1/jobs/x", "/v1/jobs", "/v1/jobs/", "/v1/jobs//", "/v1/jobs/x/", "/v1/jobs/x/y"}) {
    EXPECT_FALSE(match_path("/v1/jobs/{id}", path)) << path;
  }
  EXPECT_FALSE(match_path("/v1/scenes/{id}.glb", "/v1/scenes/abc"));
  EXPECT_FALSE(match_path("/v1/scenes/{id}.glb", "/v1/scenes/.glb"));
  EXPECT_FALSE(match_path("/v1/jobs", "/v1/jobs/"));
}

TEST(StaticFiles, ServesExactlyTheFilesOfTheFolder) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("photond_static_" + std::to_string(getpid()));
  fs::create_directories(folder / "assets");
  std::ofstream(folder / "index.html") << "<p>";
  std::ofstream(folder / "assets" / "a-1234.js") << "1";
  fs::create_symlink("/etc/passwd", folder / "passwd");
  const auto files = StaticFiles::load(folder.string());
  fs::remove_all(folder);
  ASSERT_TRUE(files.ok());
  const Response* index = files->find("/");
  ASSERT_NE(index, nullptr);
  EXPECT_EQ(index->content_type, "text/html; charset=utf-8");
  EXPECT_EQ(index->headers[0].second, "no-store");
  const Response* script = files->find("/assets/a-1234.js");
  ASSERT_NE(script, nullptr);
  EXPECT_EQ(script->content_type, "text/javascript; charset=utf-8");
  EXPECT_NE(script->headers[0].second.find("immutable"), std::string::npos);
  for (const char* path :
       {"/passwd", "/../etc/passwd", "/assets/../index.html", "/assets", "//index.html", ""}) {
    EXPECT_EQ(files->find(path), nullptr) << path;
  }
  EXPECT_FALSE(StaticFiles::load("/no/such/folder").ok());
}

}  // namespace
}  // namespace photond
